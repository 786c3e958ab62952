"""Recorded runs: opened, measured again, reported, looked at."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

from benchtool.api.plans import CaseResult, PlanResult
from benchtool.api.recorded import RecordedBlock, with_certificate
from benchtool.api.results import Results
from benchtool.errors import RecordingError, UsageError
from benchtool.notebook import table_html

if TYPE_CHECKING:
    from benchtool.profile import Profile
    from benchtool.recording import Bundle as Files, Event, Manifest
    from benchtool.report import Report

_FIRST = ("capture", "telemetry")


class Bundle:
    """A run or a recording on disk, as `open_bundle` gives it; blocks are read when asked for.

    bundle = benchtool.open_bundle("runs/20250101-120000-ripple")
    bundle.results["torque_ripple_pp"]     # as it was measured then
    bundle.block("capture").plot("i_a")
    bundle.analyze()["torque_ripple_pp"]   # measured again now
    """

    def __init__(self, files: Files) -> None:
        self._files = files

    @property
    def path(self) -> Path:
        """Its folder."""
        return self._files.directory

    @property
    def manifest(self) -> Manifest:
        """What, when, with which profile, parameters and versions; how it ended."""
        return self._files.manifest

    @property
    def parameters(self) -> dict[str, int | float | str]:
        """What the drive held, by the keys of a profile."""
        return dict(self.manifest.parameters)

    @property
    def profile(self) -> Profile:
        """The profile that it carries.

        Raises:
            RecordingError: it carries none that this version understands.
        """
        from pydantic import ValidationError

        from benchtool.misfits import explain
        from benchtool.profile import Profile

        try:
            return Profile.model_validate(tomllib.loads(self.manifest.profile_toml))
        except ValidationError as failed:
            reason = explain(Profile, failed)
        except ValueError as failed:  # not TOML, or a whole number of thousands of digits
            reason = str(failed)
        raise RecordingError(
            f"{self.path} carries no profile that this version understands ({reason}): use the benchtool "
            f"that recorded it"
        )

    @property
    def streams(self) -> tuple[str, ...]:
        """Names of what `block` gives."""
        return self._files.streams

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened, in its order."""
        return self._files.events

    @property
    def complete(self) -> bool:
        """Whether it was finished; if not, blocks hold what came until it was cut short."""
        return self._files.complete

    @property
    def verdict(self) -> str:
        """How the plan's limits were met; `none` of a recording without, and of one repetition that meets its
        own where others hold for all repetitions together."""
        return self.manifest.verdict or "none"

    @property
    def results(self) -> Results:
        """What was measured when it was recorded."""
        from benchtool.analysis import measurements_from_json, tables_from_json

        files = self._files
        return Results(measurements_from_json(files.measurements), tables_from_json(files.tables))

    def block(self, stream: str = "") -> RecordedBlock:
        """Return all rows of a stream with its gaps; without a name of the capture, or else the slow stream.

        Raises:
            RecordingError: there is no such stream, or it cannot be read.
        """
        from benchtool.analysis import measurements_from_json
        from benchtool.telemetry import Certificate

        files = self._files
        known = [each for each in (*_FIRST, *files.streams) if each in files.streams]
        name = stream or next(iter(known), "capture")
        certified = (files.certificate or {}).get("measurements", {})
        beside = name == "capture" and "transducer" in files.streams
        transducer = files.block("transducer") if beside else None
        return with_certificate(files.block(name), Certificate(measurements_from_json(certified)), transducer)

    def analyze(self) -> Results:
        """Measure it again: by the plan that it carries, a recording without one by all its channels allow.

        Raises:
            AnalysisError: its data cannot answer that.
            RecordingError: a file of it is not what was recorded.
        """
        from benchtool.api.results import analyze
        from benchtool.results import assess_bundle

        if "plan" in self.manifest.details:
            return CaseResult(assess_bundle(self._files))
        self._files.require_intact()
        return analyze(self.block(), self.profile)

    def __repr__(self) -> str:
        return f"<Bundle {self.path}: {self.manifest.what}, {self.manifest.when}>"

    def _repr_html_(self) -> str:
        manifest = self.manifest
        rows = [
            *(("what", manifest.what), ("when", manifest.when), ("profile", manifest.profile_name)),
            *(("verdict", self.verdict), ("streams", ", ".join(self.streams)), ("folder", str(self.path))),
        ]
        return table_html(("recorded run", ""), rows) + self.results._repr_html_()


def open_bundle(path: str | Path) -> Bundle:
    """Return the run or recording in a folder.

    Raises:
        RecordingError: it is none, or it is damaged; of a folder with several, the message names them.
    """
    from benchtool.recording import Bundle as Files

    folder = Path(path)
    if not (folder / "manifest.json").is_file():
        inside = sorted(each.parent for each in folder.glob("**/manifest.json"))
        if inside:
            raise RecordingError(
                f"{folder} holds {len(inside)} runs: open one of them, such as {inside[0]}, or report all by "
                f"benchtool.write_report"
            )
    return Bundle(Files.open(folder))


def folder_of(run: str | Path | Bundle | PlanResult) -> Path:
    """Return the folder of a recorded run, however it is given."""
    if isinstance(run, Bundle):
        return run.path
    return run.folder if isinstance(run, PlanResult) else Path(run)


def write_report(
    run: str | Path | Bundle | PlanResult, out: str | Path | None = None, *, pdf: bool = False
) -> Path:
    """Measure a recorded run again and write a report that needs nothing else to be read; its HTML page.

    Args:
        run: a bundle, what `run` gave, or the folder of a run of several cases or plans, of a commissioning
            or of an acceptance session.
        out: the page; `report.html` in the folder of the run without it.
        pdf: write a PDF too, beside the page.

    Raises:
        RecordingError: the run cannot be read, or the page cannot be written.
    """
    from benchtool.recording import enlist, require_unchanged
    from benchtool.report import report_files, write_report as write

    folder = folder_of(run)
    page = folder / "report.html" if out is None else Path(out)
    if page.suffix.lower() == ".pdf" and not pdf:
        raise UsageError(f"{page} names a PDF, the page is HTML: add pdf=True, or name the page")
    files = report_files(page, pdf=pdf)
    require_unchanged(folder, files if pdf else files[:1])
    page, document = write(_report_of(folder), page, pdf=pdf)
    enlist(folder, [page] if document is None else [page, document])
    return page


def _report_of(folder: Path) -> Report:
    """Return the report of what a folder holds: a commissioning, an acceptance session, or runs."""
    from benchtool.commission import read_commissioning
    from benchtool.recording import SESSION
    from benchtool.report.assembly import commissioning_report, run_report, session_report
    from benchtool.results import earlier_sessions, read_session, recorded_runs

    if (folder / SESSION).is_file():
        record = read_session(folder)
        return session_report(folder, record, earlier_sessions(folder, record))
    if (commissioning := read_commissioning(folder)) is not None:
        return commissioning_report(commissioning.document, commissioning.bundles)
    return run_report(folder, recorded_runs(folder))
