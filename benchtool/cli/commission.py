"""`benchtool commission`."""

from __future__ import annotations

import json
import math
import re
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import datetime
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import typer

from benchtool.analysis import count_of, number, undefined, without_uncertainty
from benchtool.bench import Session, open_session
from benchtool.cli import live_views, options
from benchtool.cli.fitting import named
from benchtool.cli.output import Output
from benchtool.commission import (
    DOCUMENT,
    Commissioning,
    Known,
    Step,
    StepRecorder,
    StepResult,
    StepVerdict,
    commission as run,
    commissioned_profile,
    document,
    planned,
    planned_energy,
    stated_parameters,
    step_bundles,
    steps_for,
)
from benchtool.drive import Capability, Identity
from benchtool.errors import DriveError, LinkError, RecordingError, UsageError
from benchtool.profile import eds_path, load_profile, profile_path
from benchtool.recording import Conditions, Manifest, enlist, require_empty, require_unchanged, write_whole
from benchtool.report import write_report
from benchtool.report.assembly import commissioning_report
from benchtool.run import bundle_folder, manifest_of
from benchtool.telemetry import DEFAULT_CHANNELS, DEFAULT_RATE_HZ, TelemetryStream, keep_journal

_PROFILE, _REPORT = "profile.toml", "report.html"


def commission(
    steps: Annotated[
        list[str] | None,
        typer.Argument(metavar="[STEP]...", help="A step, and those that it needs; all of them without."),
    ] = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="Print what would be played and its energy; nothing is enabled."),
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Confirm that currents may flow and the shaft may turn.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder of recording, report and profile.",
            show_default="runs/<time>-commission-<profile>",
        ),
    ] = None,
    resume: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Go on with a commissioning that was cut short.")
    ] = None,
    save: Annotated[
        bool | None,
        typer.Option(
            "--save/--no-save",
            help="Have the drive store what is found, if everything holds.",
            show_default="if every step is run",
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Store it although something is not as it should be.")
    ] = False,
    travel: Annotated[
        str,
        typer.Option(
            metavar="ANGLE",
            help="How far the shaft may turn from where it stands, as 1rev, 200deg or 3rad; steps that need "
            "a speed are left out.",
            show_default="on and on",
        ),
    ] = "",
    pdf: Annotated[bool, typer.Option("--pdf", help="Write the report as PDF too.")] = False,
    live: options.Live = None,
    seed: options.Seed = 0,
    real_time: options.RealTime = False,
    as_json: options.Json = False,
) -> int:
    """Identify a motor step by step, with the profile as its nameplate.

    Each step is recorded. If every step passed and nothing was found that is not as it should be, the drive
    stores the parameters, and a new profile has them; else the drive is left as it was found.
    """
    wanted = steps_for(steps or ())
    if not (yes or dry_run):
        raise UsageError(
            "a commissioning has rated current flow and turns the shaft: give --yes once that is safe, or "
            "--dry-run to see what it would do"
        )
    if resume is not None and out is not None:
        raise UsageError("--resume goes on in its own folder: leave --out out")
    if resume is not None and not resume.is_dir():
        raise UsageError(f"--resume {resume}: there is no such folder; give that of a commissioning")
    if resume is not None:
        require_unchanged(resume, [resume / _REPORT])
    if out is not None and not dry_run and step_bundles(out):
        raise UsageError(f"--out {out} holds a commissioning: name another folder, or --resume {out}")
    if out is not None and not dry_run:
        require_empty(out)
    travel_rad = _travel_rad(travel)
    output = Output(as_json=as_json)
    when = options.wall_time()
    keep = (not steps) if save is None else save

    def opened() -> Any:
        return open_session(
            profile, link, seed=seed, real_time=real_time, note=output.note, instruments=False, enabling=True
        )

    if dry_run:
        with opened() as session:
            session.drive.connect()
            return _show_plan(session, wanted, travel_rad, output)
    name = f"commission-{Path(profile).stem if profile.endswith('.toml') else profile}"
    with (
        bundle_folder(resume or out, when, name) as folder,
        _told_how_to_go_on(folder, output),
        live_views.open_destinations(live or (), output) as where,
    ):
        with opened() as session:
            identity = session.drive.connect()
            manifest = _manifests(session, identity, when, link, seed)
            recorder = StepRecorder(folder, manifest, resume=resume is not None)
            notes = _Notes(output)
            done = run(
                session.drive,
                session.profile,
                wanted,
                notes,
                recorder=recorder,
                keep=keep,
                force=force,
                travel_rad=travel_rad,
                watching=_shown_live(session, where, manifest, output, notes),
                ended=notes.ended,
            )
        content = _written(folder, profile, done, pdf=pdf)
        _show(output, profile, done, content)
        where.keep_open(output)
    return 0 if done.passed else 1


def _travel_rad(text: str) -> float:
    """Return an angle in rad, infinity of an empty text.

    Raises:
        UsageError: it is no angle above zero.
    """
    if not text:
        return math.inf
    found = re.fullmatch(r"\s*([0-9]*\.?[0-9]+) ?(rev|deg|rad)\s*", text)
    if found is None or not float(found[1]) > 0.0:
        raise UsageError(f"--travel '{text}' is no angle above zero: state it as 1rev, 200deg or 3rad")
    return float(found[1]) * {"rev": 2.0 * math.pi, "deg": math.pi / 180.0, "rad": 1.0}[found[2]]


def _manifests(
    session: Session, identity: Identity, when: datetime, link: str, seed: int
) -> Callable[[str], Manifest]:
    def manifest(step: str) -> Manifest:
        return manifest_of(
            session,
            identity,
            what=f"commission {step}",
            when=when.isoformat(timespec="seconds"),
            wall_s=time.time(),
            note="",
            conditions=Conditions(),
            seed=seed,
            link=link,
            command_line=tuple(sys.argv[1:]),
            details={},
        )

    return manifest


@contextmanager
def _told_how_to_go_on(folder: Path, output: Output) -> Iterator[None]:
    """Say where a commissioning that is cut short within the `with` block goes on."""
    try:
        yield
    except (KeyboardInterrupt, DriveError, LinkError):
        with suppress(RecordingError):
            if done := [each for each in step_bundles(folder) if each.manifest.verdict == StepVerdict.PASS]:
                are_done = f"{count_of(len(done), 'step')} {'is' if len(done) == 1 else 'are'} done"
                output.note(f"{are_done}: go on with --resume {folder}")
        raise


class _Notes:
    """Lines of progress and results of steps: for the person who looks on, and meanwhile for a live view."""

    def __init__(self, output: Output) -> None:
        self._takers: list[Callable[[str], None]] = [output.note]
        self._done: list[StepResult] = []
        self._shown: list[Callable[[Sequence[StepResult]], None]] = []

    def __call__(self, text: str) -> None:
        for take in self._takers:
            take(text)

    def ended(self, result: StepResult) -> None:
        """Show the results of the steps that are over, this one among them."""
        self._done.append(result)
        for show in self._shown:
            show(self._done)

    @contextmanager
    def taken_by(
        self, taker: Callable[[str], None], show: Callable[[Sequence[StepResult]], None]
    ) -> Iterator[None]:
        """Hand them to another taker, too, within the `with` block."""
        self._takers.append(taker)
        self._shown.append(show)
        try:
            yield
        finally:
            self._takers.remove(taker)
            self._shown.remove(show)


@contextmanager
def _shown_live(
    session: Session,
    where: live_views.LiveDestinations,
    manifest: Callable[[str], Manifest],
    output: Output,
    notes: _Notes,
) -> Iterator[None]:
    """Show the drive's stream, its states, what is played and what has been estimated while steps are run;
    without a destination none is streamed."""
    if not where.any:
        yield
        return
    from benchtool.live import ShownStep, steps_document

    drive = session.drive
    drive.capabilities.require(Capability.STREAM, purpose="a live view")
    names = drive.link.process_data.fitting(drive.dictionary, DEFAULT_CHANNELS)
    with live_views.stream_view(where, session, "commissioning", manifest("live"), output) as view:
        assert view is not None  # there is a destination
        sink = live_views.live_view_sink(view)

        def show(done: Sequence[StepResult]) -> None:
            shown = [
                ShownStep(
                    each.name,
                    each.verdict.value,
                    each.reason,
                    tuple(each.estimates.values()),
                    tuple(f"{finding.what}: {finding.cause}; {finding.remedy}" for finding in each.findings),
                )
                for each in done
            ]
            view.results(steps_document(view.title, shown))

        with (
            keep_journal(drive, [view.event]) as journal,
            notes.taken_by(journal.note, show),
            TelemetryStream(drive, [sink], names, DEFAULT_RATE_HZ),
        ):
            yield


def _written(folder: Path, profile: str, done: Commissioning, *, pdf: bool) -> dict[str, Any]:
    """Write profile, report and document beside the recording, with their hashes; return the document."""
    source = profile_path(profile)
    text = source.read_text(encoding="utf-8")
    made = [folder / _PROFILE, folder / DOCUMENT]
    new = commissioned_profile(text, done.parameters, done.estimates, saved=done.saved)
    write_whole(made[0], new.encode("utf-8"))
    eds = eds_path(load_profile(profile), source)
    if eds.parent == source.parent:
        made.append(Path(shutil.copy(eds, folder)))
    content = document(done, profile=made[0], bundle=folder, report=folder / _REPORT)
    page, paper = write_report(commissioning_report(content, step_bundles(folder)), folder / _REPORT, pdf=pdf)
    write_whole(made[1], (json.dumps(content, indent=2, allow_nan=False) + "\n").encode("utf-8"))
    steps = [bundle.directory for bundle in step_bundles(folder)]
    enlist(folder, [*made, page, *([] if paper is None else [paper]), *steps])
    return content


def _show(output: Output, profile: str, done: Commissioning, content: dict[str, Any]) -> None:
    rows = [
        (
            each.name,
            each.text,
            each.unit,
            _shown(content, each.name, "nameplate"),
            _shown(content, each.name, "deviation_percent"),
        )
        for each in done.estimates.values()
    ]
    if rows:
        headings = ("estimate", ">value", "unit", ">nameplate", ">%")
        output.table(f"commissioning of {profile}", headings, rows)
    for why, names in undefined(done.estimates.values()).items():
        output.sentence(f"undefined: {named(names)}: {why}", "dim")
    for why, names in without_uncertainty(done.estimates.values()).items():
        output.sentence(f"without ±: {named(names)}: {why}", "dim")
    for result in done.results:
        output.sentence(result.reason or "done", lead=f"{result.name}: {result.verdict.value}, ")
    for finding in (each for result in done.results for each in result.findings):
        output.sentence(f"{finding.cause}; {finding.remedy}", lead=f"{finding.what}: ")
    for each in content["estimates"].values():
        if "looks_like" in each:
            output.sentence(each["looks_like"], "yellow")
    for contains, holders in _contained(content).items():
        output.sentence(f"{', '.join(holders)}: with {contains}")
    if done.saved:
        output.line("the drive has stored the parameters", "green")
    else:
        output.sentence(done.not_saved, lead="the drive is as it was found, nothing was stored: ")
    output.line(f"profile: {content['profile']}")
    output.line(f"report: {content['report']}")
    output.verdict(content["verdict"])
    output.document(content)


def _contained(content: dict[str, Any]) -> dict[str, list[str]]:
    """Return what estimates contain that their names do not say, each with these names."""
    found: dict[str, list[str]] = {}
    for name, each in content["estimates"].items():
        if "contains" in each:
            found.setdefault(each["contains"], []).append(name)
    return found


def _show_plan(session: Session, steps: Sequence[Step], travel_rad: float, output: Output) -> int:
    """Print what the steps would play and what energy that takes, by the nameplate."""
    stated = stated_parameters(session.drive, session.profile)
    known = replace(Known.of(session.drive, session.profile, stated), travel_rad=travel_rad)
    plan = planned(steps, known)
    whole = planned_energy(chain(*plan.values()), known)
    rows = [
        (name, each.name, number(each.energy_J(known.R_s_ohm)))
        for name, excitations in plan.items()
        for each in excitations
    ]
    output.table("what would be played", ("step", "excitation", ">J"), rows)
    output.sentence(
        f"{number(whole.value_J)} J by {_resistance(known)}, {number(whole.least_J)} to "
        f"{number(whole.most_J)} J as far as that and friction are off and a loop is tuned again; the "
        "step 'resistance' tells more"
    )
    output.sentence("nothing was enabled; each step's estimates would be for the parameters that it sets")
    output.document(
        {
            "dry_run": True,
            "steps": {
                step.name: {
                    "energy_J": planned_energy(plan[step.name], known).value_J,
                    "sets": list(step.sets),
                }
                for step in steps
            },
            "energy_J": whole.value_J,
            "energy_range_J": [whole.least_J, whole.most_J],
        }
    )
    return 0


def _resistance(known: Known) -> str:
    if known.series_ohm is None:
        return "the nameplate's resistance, without power stage and cable (drive.on_resistance_ohm)"
    if known.series_ohm == 0.0:
        return "the resistance that is stated"
    return f"the nameplate's resistance and {number(known.series_ohm)} ohm of power stage and cable"


def _shown(content: dict[str, Any], name: str, key: str) -> str:
    stated = content["estimates"][name][key]
    return "" if stated is None else number(stated)
