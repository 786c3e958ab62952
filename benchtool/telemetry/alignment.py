"""Alignment of samples of an instrument with its own clock to the drive's ticks.

The instrument samples evenly by its own clock, and its frames are stamped on the host's clock when they
arrive. A straight line through (frame number, arrival) tells when each frame was due; the line of the drive's
records (`ClockFit`) tells which moment of the drive that was. The scatter about both lines, and the
uncertainty of the instrument's delay, make the uncertainty of the alignment.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block, Channel, Gap
from benchtool.errors import EnvironmentFailure
from benchtool.telemetry.clock_fit import ClockFit

_EARLY = 2.5  # periods by which a frame is never early
_FINE = 1000  # ticks of a row: what rounding the first one to a whole tick costs is a thousandth of a sample
_RATE_TOLERANCE = 0.01
_SAME_S = 1e-9  # two periods that agree within this over a whole record are one


@dataclass(frozen=True)
class Sampling:
    """How an instrument samples: `frame_rate_Hz` frames a second with `samples` values each, oldest first.

    The last value of a frame was taken `delay_s` before the frame's stamp, known within +-`delay_limit_s`
    (rectangular).
    """

    frame_rate_Hz: float
    samples: int = 1
    delay_s: float = 0.0
    delay_limit_s: float = 0.0


@dataclass(frozen=True)
class Alignment:
    """Uncertainty of the alignment of samples with the drive's ticks; standard uncertainties in seconds.

    `drive_s` is the scatter of the drive's records about their line, `instrument_s` that of the frames about
    theirs, `delay_s` the uncertainty of the instrument's delay, `rounding_s` that of the first sample's
    moment. `frame_rate_Hz` was found, in drive time.
    """

    standard_s: float
    drive_s: float
    instrument_s: float
    delay_s: float
    rounding_s: float
    frame_rate_Hz: float
    frames: int
    missing_frames: int


def frame_numbers(
    arrivals_s: NDArray[np.float64], frame_rate_Hz: float, counts: NDArray[np.int64] | None, wrap: int
) -> NDArray[np.int64]:
    """Return the number of every frame since the first, shape (n,); missing numbers were lost.

    Numbers increase, except that a repeated frame, by its counter, has the same number again.

    Args:
        arrivals_s: stamps, shape (n,).
        frame_rate_Hz: nominal rate.
        counts: values of the frames' own counter, shape (n,); None without one.
        wrap: values that the counter has before it begins again; a loss of `wrap` frames or more is detected
            by the stamps.

    Without a counter a frame is lost where two stamps are one and a half periods apart or more, and no more
    are lost than the whole record is too short by: late frames in a burst were not lost.

    Raises:
        EnvironmentFailure: counter and stamps contradict each other.
    """
    steps = np.diff(arrivals_s) * frame_rate_Hz
    if counts is not None:
        by_counter = np.diff(counts) % wrap
        late = np.concatenate(([0.0], np.cumsum(steps - by_counter)))  # in periods, by stamps less counter
        after = np.minimum.accumulate(late[::-1])[::-1]  # frames that are late for a while were not lost
        rounds = np.rint(np.diff(after) / wrap).astype(np.int64)
        early = np.minimum.accumulate(late)[:-1] - np.maximum.accumulate(late[::-1])[::-1][1:]
        if (contradictions := np.flatnonzero(early > _EARLY)).size:
            row = int(contradictions[0])
            raise EnvironmentFailure(
                f"the counter of the frames went from {counts[row]} to {counts[row + 1]} of {wrap} values "
                f"while {steps[row]:.3g} frames were due: the instrument restarted, or its counter wraps "
                f"elsewhere than by the DBC file; record again, or correct it there"
            )
        return np.concatenate(([0], np.cumsum(by_counter + rounds * wrap)))
    lost = np.maximum(np.rint(steps).astype(np.int64) - 1, 0)
    left = max(0, round(float(steps.sum())) - len(steps))
    kept = np.zeros_like(lost)
    for row in np.argsort(-steps, kind="stable"):
        if not (left and lost[row]):
            break
        kept[row] = min(left, lost[row])
        left -= int(kept[row])
    return np.concatenate(([0], np.cumsum(kept + 1)))


def align(
    channel: Channel,
    arrivals_s: NDArray[np.float64],
    values: NDArray[np.float64],
    numbers: NDArray[np.int64],
    sampling: Sampling,
    clock: ClockFit,
) -> tuple[Block, Alignment]:
    """Return the samples as a block in drive time, and how well they are aligned.

    Args:
        channel: its channel.
        arrivals_s: stamps of the frames on the host's clock, shape (n,).
        values: samples, shape (n, samples).
        numbers: of the frames, as `frame_numbers` gives them, shape (n,).
        sampling: how they were sampled.
        clock: of the drive's records, on the same host clock.

    Raises:
        EnvironmentFailure: fewer than three frames, or they arrive at another rate than stated.
    """
    if len(arrivals_s) < 3:
        raise EnvironmentFailure(
            f"{len(arrivals_s)} frames of '{channel.name}' came, three at least tell a line: record longer, "
            f"or check that the instrument sends"
        )
    period_s, first_s, scatter_s = _line(numbers, arrivals_s)
    found_Hz = 1.0 / period_s if period_s > 0.0 else math.inf
    if not abs(found_Hz / sampling.frame_rate_Hz - 1.0) <= _RATE_TOLERANCE:
        raise EnvironmentFailure(
            f"'{channel.name}' comes in {found_Hz:.5g} frames a second, its rate_Hz is "
            f"{sampling.frame_rate_Hz:g}: state the rate that the instrument is set to"
        )
    each = sampling.samples
    begin_s, end_s = (clock.drive_s(first_s - sampling.delay_s + at) for at in (0.0, period_s * numbers[-1]))
    drive_period_s = (end_s - begin_s) / float(numbers[-1])
    nominal_s = 1.0 / sampling.frame_rate_Hz
    if abs(drive_period_s - nominal_s) * float(numbers[-1]) < _SAME_S:
        drive_period_s = nominal_s
    row_s = drive_period_s / each
    tick_s = row_s / _FINE
    delay_s, rounding_s = sampling.delay_limit_s / math.sqrt(3.0), tick_s / math.sqrt(12.0)
    alignment = Alignment(
        standard_s=math.hypot(clock.residual_rms_s, scatter_s, delay_s, rounding_s),
        drive_s=clock.residual_rms_s,
        instrument_s=scatter_s,
        delay_s=delay_s,
        rounding_s=rounding_s,
        frame_rate_Hz=1.0 / drive_period_s,
        frames=len(arrivals_s),
        missing_frames=int(numbers[-1]) + 1 - len(arrivals_s),
    )
    block = Block(
        channels=(channel,),
        first_tick=round((begin_s - (each - 1) * row_s) / tick_s),
        stride=_FINE,
        tick_s=tick_s,
        data=np.ascontiguousarray(values.reshape(-1, 1)),
        gaps=tuple(
            Gap(int(row) * each, int(numbers[row] - numbers[row - 1] - 1) * each)
            for row in np.flatnonzero(np.diff(numbers) > 1) + 1
        ),
        alignment_s=alignment.standard_s,
    )
    return block, alignment


def _line(numbers: NDArray[np.int64], stamps: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the period, stamp of number 0 on the line, and the stamps' scatter about it, rms; by least
    squares."""
    nominal_s = (stamps[-1] - stamps[0]) / float(numbers[-1])
    deviation = (stamps - stamps[0]) - numbers * nominal_s  # small numbers, so that rounding stays small
    centred = numbers - numbers.mean()
    slope = float(centred @ (deviation - deviation.mean()) / (centred @ centred))
    first_s = float(stamps[0] + deviation.mean() - slope * numbers.mean())
    residual = deviation - deviation.mean() - slope * centred
    return nominal_s + slope, first_s, float(np.sqrt(np.mean(residual**2)))
