"""From a recording without a plan to measurements: each of its streams, in each of its steady regimes.

The file of a stream is never cut: `Recorded.source` says which of its rows were measured, by their ticks, and
has the file's SHA-256.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from benchtool.analysis import Instruments, Measurement, crop_to, measurements_from_json, steady_state_of
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.misfits import explain
from benchtool.plan import Analyses, Coordinates, measure_held
from benchtool.profile import Motor, Profile
from benchtool.recording import Bundle, Manifest
from benchtool.results.assessment import Assessment
from benchtool.results.block_result import EVERYTHING, analyze_block
from benchtool.results.calibration import Calibration
from benchtool.results.recorded import Recorded
from benchtool.results.regimes import SHORTEST_S, Regime, regimes
from benchtool.results.windows import longest_unbroken

TRANSDUCER: Final = "transducer"
BESIDE: Final = frozenset({TRANSDUCER, "energies"})
"""Streams that are not the drive's."""
_FEWEST_ROWS = 8


@dataclass(frozen=True)
class Selection:
    """What of a recording is measured, and by what.

    `stream` is its name, all of them where it is empty. `from_s` and `to_s` are in seconds after its first
    row; a window is measured as it is, without them each steady regime. `analyses` are what is left out and
    what is asked for.
    """

    stream: str = ""
    from_s: float | None = None
    to_s: float | None = None
    analyses: Analyses = field(default_factory=lambda: EVERYTHING)

    @property
    def windowed(self) -> bool:
        """Whether a window is chosen."""
        return self.from_s is not None or self.to_s is not None

    @property
    def everything(self) -> bool:
        """Whether nothing is chosen."""
        return not self.stream and not self.windowed and self.analyses == EVERYTHING


def assess_recording(bundle: Bundle, selection: Selection | None = None) -> tuple[Assessment, ...]:
    """Return what every steady regime of every stream comes to, or the window that is chosen.

    Raises:
        RecordingError: a file of the bundle is not what was recorded, or there is no such stream.
        AnalysisError: the bundle carries no motor, no rows, or no steady regime.
    """
    bundle.require_intact()
    selection, setup = selection or Selection(), _Setup.of(bundle)
    found: list[Assessment] = []
    refusals: list[str] = []
    for stream in _streams(bundle, selection):
        block = bundle.block(stream)
        try:
            for name, window, recorded in _windows(bundle, stream, block, setup.motor, selection):
                found.append(_assess(setup, name, window, recorded, selection.analyses))
        except AnalysisError as refused:
            refusals.append(str(refused))
    if not found:
        raise AnalysisError("; ".join(refusals))
    return tuple(found)


@dataclass(frozen=True)
class _Setup:
    """What all streams of a bundle have in common: motor, sensors, transducer, quality of the recording."""

    directory: Path
    motor: Motor
    calibration: Calibration
    transducer: Block | None
    quality: tuple[Measurement, ...]

    @classmethod
    def of(cls, bundle: Bundle) -> _Setup:
        certificate = bundle.certificate or {}
        return cls(
            bundle.directory,
            motor_of(bundle),
            Calibration.of(bundle.manifest),
            bundle.block(TRANSDUCER) if TRANSDUCER in bundle.streams else None,
            measurements_from_json(certificate.get("measurements", {})),
        )


def motor_of(bundle: Bundle) -> Motor:
    """Return the motor of the profile that a bundle carries.

    Raises:
        AnalysisError: it carries none that this version understands.
    """
    manifest = bundle.manifest
    content = manifest.details if "motor" in manifest.details else _content(manifest)
    if "motor" not in content:
        raise AnalysisError(
            f"{bundle.directory} carries no profile with a motor, so pole pairs and rating are not known: "
            f"give a bundle that 'benchtool run' or 'benchtool record' wrote"
        )
    try:
        return Motor.model_validate(content["motor"])
    except ValidationError as failed:
        raise AnalysisError(
            f"the motor of the profile that {bundle.directory} carries cannot be read: "
            f"{explain(Profile, failed)}; use the benchtool that recorded it"
        ) from None


def _content(manifest: Manifest) -> dict[str, Any]:
    try:
        return tomllib.loads(manifest.profile_toml)
    except (ValueError, RecursionError):
        return {}


def _streams(bundle: Bundle, selection: Selection) -> tuple[str, ...]:
    if selection.stream:
        return (selection.stream,)
    streams = tuple(name for name in bundle.streams if name not in BESIDE)
    if not streams:
        failure = bundle.manifest.details.get("failure", "it was cut short, or nothing was streamed")
        raise AnalysisError(f"{bundle.directory} holds no stream ({failure}): record again")
    return streams


def _windows(
    bundle: Bundle, stream: str, block: Block, motor: Motor, selection: Selection
) -> Iterator[tuple[str, Block, Recorded]]:
    """Name, rows and provenance of the measurements of a stream."""
    where = f"stream '{stream}' of {bundle.directory}"
    if not len(block.data):
        raise AnalysisError(f"{where} has no rows: nothing was received, record again")
    info = bundle.manifest.files.get(f"data/{stream}.parquet")
    whole = Recorded(stream, block, None if info is None else info.sha256)
    if selection.windowed:
        window = block.crop(selection.from_s, selection.to_s)
        yield _unbroken(where, f"{stream} {_ends(window, block)}", window, whole)
        return
    found = regimes(block, motor)
    steady = [each for each in found if each.steady]
    if not steady:
        raise AnalysisError(
            f"{where} has no steady state of {SHORTEST_S:g} s, {_course(found)}: choose a window with --from "
            f"and --to, in seconds after the first row"
        )
    several = len(steady) > 1
    for number, each in enumerate(steady, 1):
        name = f"{stream} {number}" if several else stream
        yield _unbroken(where, name, each.of(block), replace(whole, regimes=found))


def _course(found: tuple[Regime, ...]) -> str:
    first, last = found[0], found[-1]
    return f"{last.to_s - first.from_s:.4g} s in which the operating point keeps changing"


def _ends(window: Block, block: Block) -> str:
    begin_s = (window.first_tick - block.first_tick) * block.tick_s
    return f"{begin_s:.6g}-{begin_s + window.duration_s:.6g} s"


def _unbroken(where: str, name: str, rows: Block, recorded: Recorded) -> tuple[str, Block, Recorded]:
    """Return the longest stretch without a missing row, of which analyses with a time base can be made."""
    whole = longest_unbroken(rows)
    if len(whole.data) < _FEWEST_ROWS:
        missing = sum(gap.missing_rows for gap in rows.gaps)
        rest = (
            f", {missing} are missing in {len(rows.gaps)} gaps and the longest stretch without one has "
            f"{len(whole.data)}"
            if rows.gaps
            else ""
        )
        raise AnalysisError(
            f"{where} has {len(rows.data)} rows{rest}, at least {_FEWEST_ROWS} in a row are needed: record "
            f"longer, or at a rate that the link carries"
        )
    return name, whole, replace(recorded, rows=rows)


def _assess(setup: _Setup, name: str, window: Block, recorded: Recorded, analyses: Analyses) -> Assessment:
    shaft = _covering(setup.transducer, window) if recorded.stream != TRANSDUCER else None
    calibration = setup.calibration
    result = analyze_block(window, setup.motor, analyses, transducer=shaft, calibration=calibration)
    held = Instruments(calibration.bench, [window]).applied(tuple(measure_held(window)))
    return Assessment(
        name,
        setup.directory,
        (*result.measurements, *held),
        setup.quality,
        {},
        {},
        window,
        shaft,
        steady_state_of(result.made) if analyses.steady else None,
        result.tables,
        result.made,
        result.without,
        overdue=result.overdue,
        coordinates=Coordinates(name),
        recorded=recorded,
    )


def _covering(transducer: Block | None, window: Block) -> Block | None:
    """Return the transducer, if it was read during the whole window."""
    if transducer is None:
        return None
    try:
        crop_to(transducer, window)
    except AnalysisError:
        return None
    return transducer
