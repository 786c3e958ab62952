"""Steps as bundles: the captures of each with its estimates, and what an earlier session has finished.

A commissioning's folder has a bundle for every step that was begun. A finished one has its estimates,
findings and verdict; a step that was cut short leaves a bundle that says so. A later session takes over what
passed, as long as it is of the same drive, link and profile.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Final

from benchtool.analysis import measurements_from_json, measurements_to_json
from benchtool.block import Block
from benchtool.commission.results import StepResult, StepVerdict
from benchtool.commission.steps.step import Finding, Loop, Step
from benchtool.errors import RecordingError, UsageError
from benchtool.recording import MANIFEST, Bundle, BundleWriter, Manifest
from benchtool.report.assembly import CAPTURES, LOOPS

DETAILS: Final = "commissioned_step"
"""Key of a step's result in the details of its bundle's manifest."""


NUMBER: Final = "number"
"""Key of its place in the order in which steps were begun, likewise."""


class StepRecorder:
    """Records the steps of a commissioning into a folder.

    Args:
        folder: of the commissioning; it need not exist.
        manifest: returns that of a step which begins now; its text says which.
        resume: take over what an earlier session has finished in this folder.

    Raises:
        UsageError: that was of another drive, link, seed or profile.
        RecordingError: a bundle cannot be read.
    """

    def __init__(self, folder: Path, manifest: Callable[[str], Manifest], *, resume: bool = False) -> None:
        self.folder = folder
        self._manifest = manifest
        self._bundle: BundleWriter | None = None
        self._titles: dict[str, str] = {}  # of the streams
        self._round, self._first_of_round = 1, 0
        self._finished: dict[str, Bundle] = {}
        if resume:
            self._finished = {
                bundle.manifest.details[DETAILS]["name"]: bundle for bundle in step_bundles(folder)
            }
            now = manifest("resumption")
            for bundle in self._finished.values():
                _require_same(bundle, now)
        self._begun = len(self._finished)

    def finished(self, step: Step) -> StepResult | None:
        """Return the result of a step that has passed in an earlier session; None of another."""
        bundle = self._finished.get(step.name)
        if bundle is None:
            return None
        found = bundle.manifest.details[DETAILS]
        if found["verdict"] != StepVerdict.PASS:
            return None
        return StepResult(
            step.name,
            step.sets,
            StepVerdict.PASS,
            "",
            {each.name: each for each in measurements_from_json(bundle.measurements)},
            tuple(Finding(**each) for each in found["findings"]),
            found["planned_J"],
            found["spent_J"],
            resumed=True,
        )

    @contextmanager
    def recording(self, step: Step) -> Iterator[None]:
        """Record a step within the `with` block; one that raises leaves a bundle that states why.

        Raises:
            RecordingError: the bundle cannot be written.
        """
        place = self.folder / step.name
        if place.exists():
            _put_aside(place)
        self._titles = {}
        self._round, self._first_of_round = 1, 0
        self._begun += 1
        began = self._manifest(step.name)
        began = began.model_copy(update={"details": began.details | {NUMBER: self._begun}})
        with BundleWriter(place, began) as bundle:
            self._bundle = bundle
            try:
                yield
            except BaseException as failure:
                bundle.fail(str(failure) or type(failure).__name__)
                raise
            finally:
                self._bundle = None

    def append(self, name: str, block: Block) -> None:
        """Record the capture of an excitation.

        Raises:
            RecordingError: it cannot be written.
        """
        assert self._bundle is not None  # called while a step is recorded
        words = re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-")
        stream = f"{len(self._titles):02d}-{words}"
        self._titles[stream] = name if self._round == 1 else f"{name}, round {self._round}"
        self._bundle.append(stream, block)

    def next_round(self) -> None:
        """Take the captures from here on as those of the step, which is played again."""
        self._round += 1
        self._first_of_round = len(self._titles)

    def finish(self, result: StepResult, loops: Sequence[Loop] = ()) -> None:
        """Complete the bundle of a step; `loops` says which captures of its last round hold responses.

        Raises:
            RecordingError: it cannot be written.
        """
        assert self._bundle is not None
        streams = list(self._titles)[self._first_of_round :]
        self._bundle.finish(
            measurements_to_json(tuple(result.estimates.values())),
            verdict=result.verdict.value,
            details={
                DETAILS: {
                    "name": result.name,
                    "verdict": result.verdict.value,
                    "reason": result.reason,
                    "findings": [asdict(each) for each in result.findings],
                    "planned_J": result.planned_J,
                    "spent_J": result.spent_J,
                },
                CAPTURES: self._titles,
                LOOPS: {streams[each.capture]: asdict(each) for each in loops if result.estimates},
            },
        )


def step_bundles(folder: Path) -> tuple[Bundle, ...]:
    """Return the bundles of the steps that were finished in a folder, in the order in which they began.

    Raises:
        RecordingError: one cannot be read.
    """
    places = sorted(path.parent for path in folder.glob(f"*/{MANIFEST}") if ".cut-" not in path.parent.name)
    found = [bundle for bundle in map(Bundle.open, places) if DETAILS in bundle.manifest.details]
    return tuple(sorted(found, key=lambda bundle: bundle.manifest.details[NUMBER]))


def _require_same(bundle: Bundle, now: Manifest) -> None:
    """Check that a step was of the drive, link and profile that this session has.

    Raises:
        UsageError: it was not; the message says what differs.
    """
    then = bundle.manifest
    for what in ("profile_toml", "identity", "dictionary_hash", "link", "seed"):
        if getattr(then, what) != getattr(now, what):
            raise UsageError(
                f"{bundle.directory} is of another {what.replace('_', ' ')} than this session: what it has "
                f"found need not hold here; commission without --resume, or with what it was begun with"
            )


def _put_aside(place: Path) -> None:
    """Rename a bundle that was not finished, or did not pass."""
    for number in range(1, 1000):
        aside = place.with_name(f"{place.name}.cut-{number}")
        if not aside.exists():
            place.rename(aside)
            return
    raise RecordingError(f"{place} was begun a thousand times: remove what is not needed")
