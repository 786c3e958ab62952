"""How each measurement answers to the errors of the sensors that it is made from.

Stated here is what follows from a definition: a peak-to-peak grows with the gain and does not know the
offset, a ratio of two amplitudes of one channel knows neither. What is not stated here hangs on the waveform,
and is found by measuring again (`benchtool.analysis.instruments.MeasureAgain`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal

Bandwidth = Literal["level", "line", "band"]
"""What a number holds: a level, which a bandwidth does not touch, one line, or all up to some frequency."""

_ROOT_6, _ROOT_12 = math.sqrt(6.0), math.sqrt(12.0)


@dataclass(frozen=True)
class Found:
    """A measured value, those of all measurements by name, and the pole pairs where they are known."""

    name: str
    value: float
    values: Mapping[str, float]
    pole_pairs: int | None = None

    def other(self, name: str) -> float:
        """Value of another measurement; nan if it was not made."""
        return self.values.get(name, math.nan)


Derivative = Callable[[Found], float]


def _none(_: Found) -> float:
    return 0.0


def _own(found: Found) -> float:
    return found.value


def _one(_: Found) -> float:
    return 1.0


def _of_mean_step(_: Found) -> float:
    return 1.0 / _ROOT_12


def _of_extremes_step(_: Found) -> float:
    return 1.0 / _ROOT_6


def _minus_one(_: Found) -> float:
    return -1.0


@dataclass(frozen=True)
class Sensitivity:
    """Of a measurement to one channel.

    `gain` is its derivative by the relative error of the gain, `offset` that by the offset in the channel's
    unit. `resolution` is the standard uncertainty for each unit of the smallest step that the sensor shows.
    """

    channel: str
    gain: Derivative = _none
    offset: Derivative = _none
    resolution: Derivative = _none


@dataclass(frozen=True)
class Declared:
    """The sensitivities of measurements whose names match `pattern`, a regular expression.

    `line_Hz` is the frequency of a single line. A `bound` is what an error moves at most: a magnitude near
    zero grows with an error of either sign, which a derivative does not tell.
    """

    pattern: str
    sensitivities: tuple[Sensitivity, ...] = ()
    bandwidth: Bandwidth = "level"
    line_Hz: Derivative | None = None
    bound: bool = False


def declared(name: str) -> Declared | None:
    """What is stated of a measurement; None of one that has to be measured again."""
    return next((each for each in DECLARED if re.fullmatch(each.pattern, name)), None)


def _ripple(name: str, channel: str) -> Iterator[Declared]:
    """Mean and ripple of a channel, by the names that begin with `name`."""
    mean, pp, rms = f"{name}_mean", f"{name}_ripple_pp", f"{name}_ripple_rms"

    def of_mean(found: Found) -> float:
        return -found.value / found.other(mean)

    def of_step(whole: str) -> Derivative:
        """Of a number in percent, by the steps in the ripple that it is made of."""
        return lambda found: abs(found.value / found.other(whole)) / _ROOT_6

    yield Declared(mean, (Sensitivity(channel, _own, _one, _of_mean_step),))
    extremes = Sensitivity(channel, _own, resolution=_of_extremes_step)
    yield Declared(f"{name}_ripple_(pp|p99)", (extremes,), "band")
    yield Declared(rms, (Sensitivity(channel, _own, resolution=_of_mean_step),), "band")
    for whole, part in ((pp, ""), (rms, "_rms")):
        step = of_step(whole)
        percent = f"{name}_ripple{part}_percent"
        yield Declared(f"{percent}_of_mean", (Sensitivity(channel, _none, of_mean, step),), "band")
        yield Declared(f"{percent}_of_rated", (Sensitivity(channel, _own, resolution=step),), "band")


def _orders(name: str, channel: str) -> Iterator[Declared]:
    def turning_Hz(found: Found) -> float:
        order = float(found.name.rpartition("_")[2])
        return order * found.other("fundamental_frequency") / (found.pole_pairs or math.nan)

    yield Declared(f"{name}_order_largest", (Sensitivity(channel),))
    yield Declared(rf"{name}_order_[1-9]\d*", (Sensitivity(channel, _own),), "line", turning_Hz)
    yield Declared(f"{name}_line_frequency", (Sensitivity(channel),))
    by_line = f"{name}_line_frequency"
    yield Declared(
        f"{name}_line_amplitude",
        (Sensitivity(channel, _own),),
        "line",
        lambda found: found.other(by_line),
    )


def _other(name: str, factor: float) -> Derivative:
    return lambda found: factor * found.other(name)


def _sequences() -> Iterator[Declared]:
    """Each phase is a third of each symmetrical component, whatever its angle to that."""
    components = tuple(f"current_sequence_{each}" for each in ("positive", "negative", "zero"))

    def of_phase(found: Found) -> float:
        return sum(found.other(each) for each in components) / 3.0

    def in_percent(found: Found) -> float:
        return 100.0 * of_phase(found) / found.other(components[0])

    for pattern, gain in (
        ("|".join(components), of_phase),
        ("current_unbalance(_zero)?_percent", in_percent),
    ):
        phases = tuple(Sensitivity(channel, gain) for channel in ("i_a", "i_b", "i_c"))
        yield Declared(pattern, phases, bound=True)


def _all() -> Iterator[Declared]:
    for name, channel in (
        ("torque", "torque"),
        ("true_torque", "torque_transducer"),
        ("current", "i_a"),
        ("speed", "omega_m"),
    ):
        yield from _ripple(name, channel)
        if channel != "torque_transducer":
            yield from _orders(name, channel)
    yield Declared(
        "torque_error",
        (
            Sensitivity("torque", _other("torque_mean", 1.0), _one, _of_mean_step),
            Sensitivity("torque_transducer", _other("true_torque_mean", -1.0), _minus_one, _of_mean_step),
        ),
    )
    extremes = Sensitivity("psi_s", _own, resolution=_of_extremes_step)
    yield Declared("flux_ripple_pp", (extremes,), "band")
    yield Declared("fundamental_frequency|switching_frequency_mean")
    fundamental = Sensitivity("i_a", _own)
    yield Declared(
        "current_fundamental", (fundamental,), "line", lambda found: found.other("fundamental_frequency")
    )
    yield Declared("current_(max_low_harmonic|tdd|noise_floor|noise_density)", (fundamental,), "band")
    yield Declared(r"current_thd(|_corrected|_r|_n|g|s)", (Sensitivity("i_a"),), "band")
    yield from _sequences()
    for signal in ("omega_m", "torque", "u_dc"):
        yield Declared(f"{signal}_reached", (Sensitivity(signal, _own, _one, _of_mean_step),))


DECLARED: Final = tuple(_all())
"""Every kind of measurement whose sensitivities follow from its definition."""
