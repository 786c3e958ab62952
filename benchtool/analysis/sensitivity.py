"""Sensitivities of measurements to the errors of the sensors that they are computed from.

Declared here are the sensitivities that follow from a definition: a peak-to-peak value scales with the gain
and is independent of the offset, a ratio of two amplitudes of one channel is independent of both. Others
depend on the waveform, and are found by measuring again (`benchtool.analysis.instruments.MeasureAgain`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal

Bandwidth = Literal["level", "line", "largest", "sequence", "band", "noise", "power", "extremes"]
"""What a number holds: a level, which a bandwidth does not touch, one line, the largest of many, one line of
each of three phases, the harmonics up to some frequency each by itself, the noise between them, the power of
all components together, or their extremes.

Where a signal is sampled too slowly, what is faster folds into the band: power keeps its sum, components do
not keep their places, and extremes are missed.
"""

_BESIDE: Final[Mapping[str, Bandwidth]] = {"flux_radius_pp": "extremes", "flux_radius_rms": "power"}
"""Of numbers whose sensitivities hang on the waveform."""

_SIGNED: Final = re.compile(r".*(_mean|_reached|_delay|_dB|_peak|margin\w*|plateau_\w+)")
"""Numbers that hang on the waveform and may be below zero."""

_ROOT_6, _ROOT_12 = math.sqrt(6.0), math.sqrt(12.0)


@dataclass(frozen=True)
class Found:
    """A measured value, those of all measurements by name, and the frequency of its line, if it is one."""

    name: str
    value: float
    values: Mapping[str, float]
    line_Hz: float = math.nan

    def other(self, name: str) -> float:
        """Return the value of another measurement; nan if it was not made."""
        return self.values.get(name, math.nan)


Derivative = Callable[[Found], float]


def _none(_: Found) -> float:
    return 0.0


def _own(found: Found) -> float:
    return found.value


def _third(found: Found) -> float:
    return found.value / 3.0


def _minus_third(found: Found) -> float:
    return -found.value / 3.0


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
    """Sensitivity of a measurement to one channel.

    `gain` is its derivative by the relative error of the gain, `offset` that by the offset in the channel's
    unit. `resolution` is the standard uncertainty for each unit of the smallest step that the sensor shows,
    where no waveform tells how far its errors average out.
    """

    channel: str
    gain: Derivative = _none
    offset: Derivative = _none
    resolution: Derivative = _none


@dataclass(frozen=True)
class Declared:
    """The sensitivities of measurements whose names match `pattern`, a regular expression.

    `as_ratio` is of a band in percent of the fundamental. A `bound` is the largest change that an error
    causes: a magnitude near zero grows with an error of either sign, which a derivative does not show.
    """

    pattern: str
    sensitivities: tuple[Sensitivity, ...] = ()
    bandwidth: Bandwidth = "level"
    bound: bool = False
    as_ratio: bool = False

    @property
    def by_resolution(self) -> bool:
        """Whether steps of a reading move it: not a frequency, nor the number of an order."""
        return self.bandwidth != "level" or any(each.resolution is not _none for each in self.sensitivities)


def declared(name: str) -> Declared | None:
    """Return the declaration for a measurement; None if it has to be measured again."""
    return next((each for each in DECLARED if re.fullmatch(each.pattern, name)), None)


def holds(name: str) -> Bandwidth:
    """Return what a measurement holds; a level, where nothing else is stated."""
    stated = declared(name)
    return _BESIDE.get(name, "level") if stated is None else stated.bandwidth


def is_positive(name: str) -> bool:
    """Return whether a number that hangs on the waveform is a size: an rms, a time, an overshoot, a gain."""
    return _SIGNED.fullmatch(name) is None


def _ripple(name: str, channel: str) -> Iterator[Declared]:
    """Yield the mean and ripple of a channel, by the names that begin with `name`."""
    mean, pp, rms = f"{name}_mean", f"{name}_ripple_pp", f"{name}_ripple_rms"

    def of_mean(found: Found) -> float:
        return -found.value / found.other(mean)

    def of_step(whole: str) -> Derivative:
        """Return the derivative of a percentage by the steps in its ripple."""
        return lambda found: abs(found.value / found.other(whole)) / _ROOT_6

    yield Declared(mean, (Sensitivity(channel, _own, _one, _of_mean_step),))
    extremes = Sensitivity(channel, _own, resolution=_of_extremes_step)
    yield Declared(f"{name}_ripple_(pp|percentile_range)", (extremes,), "extremes")
    yield Declared(rms, (Sensitivity(channel, _own, resolution=_of_mean_step),), "power")
    parts: tuple[tuple[str, str, Bandwidth], ...] = ((pp, "", "extremes"), (rms, "_rms", "power"))
    for whole, part, holds in parts:
        step = of_step(whole)
        percent = f"{name}_ripple{part}_percent"
        yield Declared(f"{percent}_of_mean", (Sensitivity(channel, _none, of_mean, step),), holds)
        yield Declared(f"{percent}_of_rated", (Sensitivity(channel, _own, resolution=step),), holds)


def _orders(name: str, channel: str) -> Iterator[Declared]:
    yield Declared(f"{name}_order_largest", (Sensitivity(channel),))
    names = rf"{name}_order_([1-9]\d*p?|slots|cogging|largest_amplitude)"
    yield Declared(names, (Sensitivity(channel, _own),), "line")
    yield Declared(f"{name}_line_frequency", (Sensitivity(channel),))
    yield Declared(f"{name}_line_amplitude", (Sensitivity(channel, _own),), "line")


def _other(name: str, factor: float) -> Derivative:
    return lambda found: factor * found.other(name)


def _sequences() -> Iterator[Declared]:
    """Yield the sensitivities of symmetrical components: each phase contributes a third, at any angle."""
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
        yield Declared(pattern, phases, "sequence", bound=True)


def _balances() -> Iterator[Declared]:
    """Yield the parameters of a flux balance and of one of torque.

    Voltages scale with that of the dc link; a third of the error of each phase's gain is common to all.
    """
    link = Sensitivity("u_dc", _own)
    yield Declared("flux_balance_(psi_r|dead_time_voltage)", (link,))
    by_currents = tuple(Sensitivity(phase, _minus_third) for phase in ("i_a", "i_b", "i_c"))
    yield Declared("flux_balance_(R_s|L_d|L_q)", (link, *by_currents))
    torque = tuple(Sensitivity(phase, _third) for phase in ("i_a", "i_b", "i_c"))
    yield Declared("motion_balance_(J|friction|coulomb)", (link, *torque))
    yield Declared("flux_balance_(encoder_offset|current_gain_[abc]|(belief_)?error_rms)")


def _all() -> Iterator[Declared]:
    for name, channel in (
        ("torque", "torque"),
        ("transducer_torque", "torque_transducer"),
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
            Sensitivity(
                "torque_transducer", _other("transducer_torque_mean", -1.0), _minus_one, _of_mean_step
            ),
        ),
    )
    extremes = Sensitivity("psi_s", _own, resolution=_of_extremes_step)
    yield Declared("flux_ripple_pp", (extremes,), "extremes")
    yield Declared("fundamental_frequency|switching_frequency_mean|coherence_(min|median)")
    fundamental = Sensitivity("i_a", _own)
    yield Declared(r"current_(fundamental|harmonic_[1-9]\d*)", (fundamental,), "line")
    yield Declared("current_max_low_harmonic", (fundamental,), "largest")
    yield Declared("current_tdd", (fundamental,), "band")
    yield Declared("current_noise_(floor|density)", (fundamental,), "noise")
    yield Declared(
        r"current_thd_(r|f(_noise_corrected|_plus_noise|_groups|_subgroups)?)",
        (Sensitivity("i_a"),),
        "band",
        as_ratio=True,
    )
    yield from _sequences()
    yield from _balances()
    for signal in ("omega_m", "torque", "u_dc"):
        yield Declared(f"{signal}_reached", (Sensitivity(signal, _own, _one, _of_mean_step),))


DECLARED: Final = tuple(_all())
"""Every kind of measurement whose sensitivities follow from its definition."""
