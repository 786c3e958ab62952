"""Recorded runs on disk: grouping of bundles, each measured again."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from pydantic import ValidationError

from benchtool.errors import (
    AnalysisError,
    BenchError,
    NoSuchRecording,
    PlugInError,
    RecordingError,
    UsageError,
)
from benchtool.file_kinds import FileKind, mistaken
from benchtool.plan import Verdict, cases, recorded_plan, worst
from benchtool.recording import Bundle
from benchtool.results.assessment import Assessment
from benchtool.results.case_assessment import assess_bundle
from benchtool.results.incomplete import cut_short, incomplete
from benchtool.results.recordings import Selection, assess_recording
from benchtool.results.repetitions import Repeated, over_repetitions
from benchtool.results.run_result import RunResult
from benchtool.results.tables import assess_table, is_table

_MANIFEST = "manifest.json"
_PUT_ASIDE = re.compile(r"\.cut-\d+$")  # incomplete cases that a resumed run has repeated


@dataclass(frozen=True)
class RecordedCase:
    """One bundle, or one steady regime of a recording.

    Without an assessment, `failure` says why there is none, and `error` if that was one.
    """

    name: str
    bundle: Bundle
    assessment: Assessment | None
    failure: str = ""
    error: BenchError | None = None

    @property
    def verdict(self) -> Verdict:
        """The assessment's; a run that failed or was cut short fails, a recording without a plan has none."""
        if self.assessment is not None and self.bundle.complete:
            return self.assessment.verdict
        told = self.bundle.complete and (self.error is None or isinstance(self.error, AnalysisError))
        return Verdict.FAIL if self.planned or not told else Verdict.NONE

    @property
    def planned(self) -> bool:
        """Whether it is of a plan."""
        return is_planned(self.bundle)


@dataclass(frozen=True)
class RecordedRun:
    """The cases of one plan, in the order in which they ran; `name` is empty where there is one plan only.

    `lone` tells that the bundle of one case was asked for by itself, and not its run.
    """

    name: str
    folder: Path
    cases: tuple[RecordedCase, ...]
    lone: bool = False

    @cached_property
    def repeated(self) -> Mapping[str, tuple[Repeated, ...]]:
        """The repetitions of each case together. For a run with missing cases only the limits over
        repetitions are listed, as missed; for a lone one nothing."""
        measured = {case.name: case.assessment.measurements for case in self.cases if case.assessment}
        if self.lone or not measured:
            return {}
        carrier = next(case.bundle for case in self.cases if case.assessment)
        if not is_planned(carrier):
            return {}
        plan = recorded_plan(carrier.manifest.details["plan"])
        if plan.judge == "each" and any(case.name not in measured for case in cases(plan)):
            return {}
        return over_repetitions(plan, measured)

    @cached_property
    def missing(self) -> tuple[str, ...]:
        """The cases of the plan that have no recording; none where the plan is not understood, or has one
        case."""
        carrier = next((case.bundle for case in self.cases if case.planned), None)
        if carrier is None:
            return ()
        try:
            planned = cases(recorded_plan(carrier.manifest.details["plan"]))
        except ValidationError:
            return ()
        there = {case.name for case in self.cases}
        return () if len(planned) == 1 else tuple(case.name for case in planned if case.name not in there)

    @cached_property
    def incomplete(self) -> str:
        """What of the run is there and what to do, where it did not come to its end; empty where it did."""
        of_bundle = {case.bundle.directory: (case.name, case.bundle) for case in self.cases}
        return incomplete(self.folder, tuple(of_bundle.values()), () if self.lone else self.missing)

    @cached_property
    def result(self) -> RunResult:
        """What its measured cases come to, as when the run was made."""
        return RunResult(tuple(case.assessment for case in self.cases if case.assessment), self.repeated)

    @property
    def verdict(self) -> Verdict:
        return worst((*(case.verdict for case in self.cases), self.result.verdict))

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """As that of the run when it was made; None where no case has a transducer."""
        return self.result.verdict_by_transducer


def recorded_runs(folder: Path, selection: Selection | None = None) -> tuple[RecordedRun, ...]:
    """Return what `folder` holds: a bundle, the bundles of one plan, or a folder of these for each plan.

    A recording without a plan has a case for each steady regime. With a `selection`, which needs one bundle,
    a run is measured as a recording too, without the limits of its plan.

    Raises:
        UsageError: a selection of several bundles.
        RecordingError: it holds none, or one cannot be read.
        PlugInError: an analysis of another package cannot be used.
    """
    bundles = recorded_bundles(folder)
    if bundles[0].directory == folder:
        return (RecordedRun("", folder, tuple(_cases(bundles[0], selection)), lone=True),)
    if selection is not None and not selection.everything:
        raise UsageError(
            f"{folder} is no single bundle, of which a part can be measured: give one of those in it"
        )
    groups: dict[Path, list[Bundle]] = {}
    for bundle in bundles:
        groups.setdefault(bundle.directory.parent, []).append(bundle)
    runs = [run for place, bundles in sorted(groups.items()) for run in _of_one_plan(folder, place, bundles)]
    return tuple(runs) if len(runs) > 1 else (RecordedRun("", runs[0].folder, runs[0].cases),)


def recorded_bundles(folder: Path) -> tuple[Bundle, ...]:
    """Return the bundle in `folder`, or those of a run of several cases or plans, by their path.

    Raises:
        NoSuchRecording: it holds none.
        RecordingError: one cannot be read.
    """
    if folder.exists() and not folder.is_dir():
        why = mistaken(folder, FileKind.RUN)
        raise NoSuchRecording(why or f"{folder} is a file: give the folder of a run")
    if not folder.exists():
        raise NoSuchRecording(f"{folder} does not exist: give the folder of a run")
    if (folder / _MANIFEST).is_file():
        return (Bundle.open(folder),)
    paths = sorted((*folder.glob(f"*/{_MANIFEST}"), *folder.glob(f"*/*/{_MANIFEST}")))
    found = tuple(Bundle.open(path.parent) for path in paths if not _PUT_ASIDE.search(path.parent.name))
    if not found:
        raise NoSuchRecording(f"{folder} holds no run bundle: give the folder of a run")
    return found


def incomplete_runs(folder: Path) -> tuple[str, ...]:
    """Return what is said of each run in a folder that did not come to its end; nothing is measured.

    Raises: as `recorded_bundles`.
    """
    bundles = recorded_bundles(folder)
    lone = bundles[0].directory == folder
    groups: dict[tuple[Path, str], list[Bundle]] = {}
    for bundle in bundles:
        groups.setdefault((bundle.directory.parent, bundle.manifest.what), []).append(bundle)
    runs = (
        RecordedRun("", folder if lone else place, tuple(_unmeasured(each) for each in members), lone)
        for (place, _), members in groups.items()
    )
    return tuple(run.incomplete for run in runs if run.incomplete)


def _unmeasured(bundle: Bundle) -> RecordedCase:
    return RecordedCase(_case_name(bundle), bundle, None, cut_short(bundle))


def _case_name(bundle: Bundle) -> str:
    return str(bundle.manifest.details.get("case", bundle.directory.name))


def complete_cases(folder: Path, selection: Selection | None = None) -> list[Assessment]:
    """Return every case of a run that was finished, measured again; of a recording, what came of it.

    Raises:
        RecordingError: there is none, or a file of one is not what was recorded.
        AnalysisError: the data cannot answer what the plan asks.
    """
    return complete_of(recorded_runs(folder, selection), folder)


def complete_of(runs: Sequence[RecordedRun], folder: Path) -> list[Assessment]:
    """Return every case of runs in a folder that was finished.

    Raises: as `complete_cases`.
    """
    recorded = [case for run in runs for case in run.cases]
    found = [case for case in recorded if case.bundle.complete or (case.assessment and not case.planned)]
    if not found:
        raise RecordingError("; ".join(run.incomplete for run in runs))
    return [case.assessment or _measured_before(case) for case in found]


def repeated_cases(runs: Sequence[RecordedRun]) -> dict[str, tuple[Repeated, ...]]:
    """Return what runs of several cases come to over the repetitions, by the case's name, with the plan's
    where there are several."""
    several = (run for run in runs if len(run.cases) > 1)
    return {
        f"{run.name}/{case}" if run.name else case: together
        for run in several
        for case, together in run.repeated.items()
    }


def is_planned(bundle: Bundle) -> bool:
    """Return whether a plan was run, whose limits hold."""
    return "plan" in bundle.manifest.details


def _of_one_plan(root: Path, place: Path, bundles: list[Bundle]) -> list[RecordedRun]:
    """Return the bundles of a folder by their plan; a plan of one case stands beside those of several."""
    by_plan: dict[str, list[Bundle]] = {}
    for bundle in bundles:
        by_plan.setdefault(bundle.manifest.what, []).append(bundle)
    runs = []
    for members in by_plan.values():
        alone = len(members) == 1 and (place == root or len(by_plan) > 1)
        folder = members[0].directory if alone else place
        name = folder.name
        found = [case for bundle in members for case in _cases(bundle, several=len(members) > 1)]
        runs.append(RecordedRun(name, folder, _in_order(found)))
    return sorted(runs, key=lambda run: run.name)


def _in_order(found: list[RecordedCase]) -> tuple[RecordedCase, ...]:
    """Return the cases in the order in which they ran, and of equal times in that of their plan."""
    names: list[str] = []
    with suppress(KeyError, ValidationError):
        plan = recorded_plan(found[0].bundle.manifest.details["plan"])
        names = [case.name for case in cases(plan)]
    places = {name: place for place, name in enumerate(names)}
    return tuple(
        sorted(
            found, key=lambda case: (case.bundle.manifest.when, places.get(case.name, len(names)), case.name)
        )
    )


def _cases(
    bundle: Bundle, selection: Selection | None = None, *, several: bool = False
) -> list[RecordedCase]:
    """Return the case of a bundle, or the regimes of a recording as one each, of `several` by the bundle's
    name."""
    details = bundle.manifest.details
    name = _case_name(bundle)
    failure = str(details.get("failure", ""))
    if not failure and not bundle.complete:
        failure = f"the run was cut short before it ended: {cut_short(bundle)}"
    try:
        found = _assessments(bundle, selection)
        if several:
            found = tuple(
                replace(each, case=f"{name} {each.case}") if each.recorded else each for each in found
            )
        return [
            RecordedCase(each.case if each.recorded else name, bundle, each, failure) for each in found
        ] or [RecordedCase(name, bundle, None, failure)]
    except PlugInError:
        raise  # an error of this installation, not of the recording
    except BenchError as error:
        return [RecordedCase(name, bundle, None, failure or str(error), error)]


def _assessments(bundle: Bundle, selection: Selection | None) -> tuple[Assessment, ...]:
    """By the plan, or as a recording; none of a table of another tool, which carries no motor."""
    chosen = selection is not None and not selection.everything
    if is_planned(bundle) and not chosen:
        return (assess_bundle(bundle),)
    bundle.require_intact()
    return assess_recording(bundle, selection) if bundle.manifest.profile_toml or chosen else ()


def _measured_before(case: RecordedCase) -> Assessment:
    """Return the numbers of a table; a bundle that should have been measured is refused."""
    if case.error is None and is_table(case.bundle):
        return assess_table(case.bundle)
    if isinstance(case.error, RecordingError):
        raise case.error
    raise AnalysisError(
        case.failure or f"{case.bundle.directory} was not recorded by a plan: give a run of one"
    )
