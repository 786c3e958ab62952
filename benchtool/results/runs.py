"""Recorded runs on disk: which bundles belong together, and what each comes to when it is measured again."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pydantic import ValidationError

from benchtool.errors import AnalysisError, BenchError, PlugInError, RecordingError
from benchtool.plan.cases import cases
from benchtool.plan.limits import Verdict, worst
from benchtool.plan.model import Plan
from benchtool.recording import Bundle
from benchtool.results.assessment import Assessment, assess_bundle
from benchtool.results.repetitions import Repeated, over_repetitions

_MANIFEST = "manifest.json"
_PUT_ASIDE = re.compile(r"\.cut-\d+$")  # half-done cases that a resumed run has done again


@dataclass(frozen=True)
class RecordedCase:
    """One bundle; without an assessment, `failure` says why there is none, and `error` if that was one."""

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
        return (
            Verdict.NONE if "plan" not in self.bundle.manifest.details and not self.failure else Verdict.FAIL
        )


@dataclass(frozen=True)
class RecordedRun:
    """The cases of one plan, in the order in which they ran; `name` is empty where there is one plan only."""

    name: str
    folder: Path
    cases: tuple[RecordedCase, ...]

    @cached_property
    def repeated(self) -> Mapping[str, tuple[Repeated, ...]]:
        """The repetitions of each case together. A run of which cases are missing has only the limits that
        hold over repetitions to tell of, which it does not meet."""
        measured = {case.name: case.assessment.measurements for case in self.cases if case.assessment}
        if not measured:
            return {}
        carrier = next(case.bundle for case in self.cases if case.assessment)
        plan = Plan.model_validate(carrier.manifest.details["plan"])
        if plan.judge == "each" and any(case.name not in measured for case in cases(plan)):
            return {}
        return over_repetitions(plan, measured)

    @property
    def verdict(self) -> Verdict:
        together = (each.verdict for group in self.repeated.values() for each in group)
        return worst((*(case.verdict for case in self.cases), *together))


def recorded_runs(folder: Path) -> tuple[RecordedRun, ...]:
    """What `folder` holds: a bundle, the bundles of one plan, or a folder of these for each plan.

    Raises:
        RecordingError: it holds none, or one cannot be read.
        PlugInError: an analysis of another package cannot be used.
    """
    if folder.exists() and not folder.is_dir():
        raise RecordingError(f"{folder} is a file: give the folder of a run")
    if not folder.exists():
        raise RecordingError(f"there is no {folder}: give the folder of a run")
    if (folder / _MANIFEST).is_file():
        return (RecordedRun("", folder, (_case(Bundle.open(folder)),)),)
    groups: dict[Path, list[Bundle]] = {}
    for path in sorted((*folder.glob(f"*/{_MANIFEST}"), *folder.glob(f"*/*/{_MANIFEST}"))):
        place = path.parent
        if not _PUT_ASIDE.search(place.name):
            groups.setdefault(place.parent, []).append(Bundle.open(place))
    if not groups:
        raise RecordingError(f"{folder} holds no run bundle: give the folder of a run")
    runs = [run for place, bundles in sorted(groups.items()) for run in _of_one_plan(folder, place, bundles)]
    return tuple(runs) if len(runs) > 1 else (RecordedRun("", runs[0].folder, runs[0].cases),)


def complete_cases(folder: Path) -> list[Assessment]:
    """Every case of a run that was finished, measured again.

    Raises:
        RecordingError: there is none, or a file of one is not what was recorded.
        AnalysisError: the data cannot answer what the plan asks.
    """
    found = [case for run in recorded_runs(folder) for case in run.cases if case.bundle.complete]
    if not found:
        raise RecordingError(f"{folder} holds no complete run bundle: give the folder of a run")
    return [case.assessment or _refuse(case) for case in found]


def _of_one_plan(root: Path, place: Path, bundles: list[Bundle]) -> list[RecordedRun]:
    """The bundles of a folder by their plan; a plan of one case stands beside those of several."""
    by_plan: dict[str, list[Bundle]] = {}
    for bundle in bundles:
        by_plan.setdefault(bundle.manifest.what, []).append(bundle)
    runs = []
    for members in by_plan.values():
        alone = len(members) == 1 and (place == root or len(by_plan) > 1)
        folder = members[0].directory if alone else place
        name = folder.name
        runs.append(RecordedRun(name, folder, _in_order([_case(bundle) for bundle in members])))
    return sorted(runs, key=lambda run: run.name)


def _in_order(found: list[RecordedCase]) -> tuple[RecordedCase, ...]:
    """Cases in the order in which they ran, and of equal times in that of their plan."""
    names: list[str] = []
    with suppress(KeyError, ValidationError):
        plan = Plan.model_validate(found[0].bundle.manifest.details["plan"])
        names = [case.name for case in cases(plan)]
    places = {name: place for place, name in enumerate(names)}
    return tuple(
        sorted(
            found, key=lambda case: (case.bundle.manifest.when, places.get(case.name, len(names)), case.name)
        )
    )


def _case(bundle: Bundle) -> RecordedCase:
    details = bundle.manifest.details
    name = str(details.get("case", bundle.directory.name))
    failure = str(details.get("failure", ""))
    if not failure and not bundle.complete:
        failure = "the run was cut short before it ended"
    try:
        bundle.require_intact()
        result = assess_bundle(bundle) if "plan" in details else None
        return RecordedCase(name, bundle, result, failure)
    except PlugInError:
        raise  # it is of this installation and not of the recording
    except BenchError as error:
        return RecordedCase(name, bundle, None, failure or str(error), error)


def _refuse(case: RecordedCase) -> Assessment:
    if isinstance(case.error, RecordingError):
        raise case.error
    raise AnalysisError(
        case.failure or f"{case.bundle.directory} was not recorded by a plan: give a run of one"
    )
