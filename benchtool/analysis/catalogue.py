"""Every analysis of a steady state: the channels it needs, how it is made, and by that the names it measures.

`STEADY` is what a steady state is measured by, in the order in which the numbers are printed. The names of
an analysis are those that it gives of `benchtool.analysis.specimen`, a capture that was computed, so that no
list of names stands beside the code that makes them. Names that hang on the data (`torque_order_24`) are
stated as `patterns`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Final, Self

import numpy as np

from benchtool.analysis.dynamics.bode import analyze_response
from benchtool.analysis.dynamics.step import analyze_step
from benchtool.analysis.flux_trajectory import flux_trajectory
from benchtool.analysis.measurement import Measurement, Table
from benchtool.analysis.orders.orders import order_analysis
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.residual import NEEDED as NEEDED_TO_PREDICT
from benchtool.analysis.residual import torque_residual
from benchtool.analysis.ripple import peak_to_peak_number
from benchtool.analysis.specimen import (
    SPECIMEN_MOTOR,
    response_specimen,
    steady_specimen,
    step_specimen,
)
from benchtool.analysis.spectra.current import CurrentSpectrum, current_spectrum
from benchtool.analysis.spectra.lines import spectral_lines
from benchtool.analysis.spectra.unbalance import current_unbalance
from benchtool.analysis.switching import switching_frequency, switching_states
from benchtool.analysis.torque import torque_ripple, true_torque
from benchtool.block import Block
from benchtool.profile import Motor

_FEWEST_REVOLUTIONS = 2.0


@dataclass(frozen=True)
class Window:
    """A capture in steady state, and what its analyses share, computed once.

    `torque_rated_Nm` and `current_rated_A_rms` are the bases of numbers "of rated"; without the second there
    is no `current_tdd`. `transducer` has channel torque_transducer and covers the capture's time. `motor` is
    needed by those analyses that put its parameters to the test, `slots` names orders.
    """

    block: Block
    pole_pairs: int
    torque_rated_Nm: float
    current_rated_A_rms: float | None = None
    transducer: Block | None = None
    motor: Motor | None = None

    @classmethod
    def of(cls, block: Block, motor: Motor, transducer: Block | None = None) -> Self:
        """The window of a machine whose rating and parameters are known."""
        return cls(block, motor.pole_pairs, motor.T_N_Nm, motor.I_N_A_rms, transducer, motor)

    @cached_property
    def track(self) -> PhaseTrack | None:
        """Electrical phase by theta_m, without that by i_a; None without both.

        Raises:
            AnalysisError: fewer than two electrical periods, or a speed that is not steady.
        """
        names = self.block.names
        if "theta_m" in names:
            return track_angle(np.ascontiguousarray(self.block.column("theta_m")), self.pole_pairs)
        if "i_a" in names:
            return track_tone(np.ascontiguousarray(self.block.column("i_a")), "i_a")
        return None

    @cached_property
    def current(self) -> CurrentSpectrum:
        """Spectrum of i_a."""
        assert self.track is not None  # i_a alone gives one
        return current_spectrum(self.block, "i_a", self.track, current_rated_A_rms=self.current_rated_A_rms)

    @cached_property
    def torque(self) -> tuple[Measurement, ...]:
        """Mean and ripple of the drive's estimate."""
        what = "the drive's estimate torque"
        rated = self.torque_rated_Nm
        return torque_ripple(self.block, torque_rated_Nm=rated, track=self.track, what=what)

    @cached_property
    def true_torque(self) -> tuple[Measurement, ...]:
        """Mean and ripple of the transducer's torque and, where there is an estimate, the error of that."""
        assert self.transducer is not None
        estimate = self.torque[0] if "torque" in self.block.names else None
        rated = self.torque_rated_Nm
        return true_torque(
            self.transducer, self.block, estimate=estimate, torque_rated_Nm=rated, track=self.track
        )

    @cached_property
    def residual(self) -> tuple[Measurement, ...]:
        """What a model of the motor leaves of the torque; nothing without a motor."""
        return () if self.motor is None else torque_residual(self.block, self.motor, self.transducer)


@dataclass(frozen=True)
class Findings:
    """What an analysis found."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class Analysis:
    """One analysis of a steady state.

    Attributes:
        title: what it measures, in words.
        channels: of the capture, all of which it needs.
        measure: makes it; raises AnalysisError where the data do not allow it.
        transducer: whether it needs the torque transducer as well.
        every_tick: whether it needs a capture with stride 1.
        patterns: regular expressions of the names that hang on the data.
    """

    title: str
    channels: tuple[str, ...]
    measure: Callable[[Window], Findings]
    transducer: bool = False
    every_tick: bool = False
    patterns: tuple[str, ...] = ()

    def missing(self, channels: Set[str]) -> tuple[str, ...]:
        """The channels that it needs and that are not among these."""
        return tuple(name for name in self.channels if name not in channels)

    def possible(self, channels: Set[str], *, transducer: bool, stride: int = 1) -> bool:
        """Whether a capture of these channels, every `stride` ticks, allows it."""
        has_all = not self.missing(channels) and (transducer or not self.transducer)
        return has_all and (stride == 1 or not self.every_tick)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names that it always measures."""
        found = self.measure(_specimen()).measurements
        return tuple(each.name for each in found if not self._of_data(each.name))

    def measures(self, name: str) -> bool:
        """Whether it may give a measurement of that name."""
        return self._of_data(name) or name in self.names

    def _of_data(self, name: str) -> bool:
        return any(re.fullmatch(pattern, name) for pattern in self.patterns)


def _flux_ripple(window: Window) -> Findings:
    what = "the drive's estimate psi_s (peak)"
    number = peak_to_peak_number(window.block, "psi_s", "flux_ripple_pp", track=window.track, what=what)
    return Findings((number,))


def _torque_error(window: Window) -> Findings:
    return Findings(tuple(each for each in window.true_torque if each.name == "torque_error"))


def _true_torque(window: Window) -> Findings:
    return Findings(tuple(each for each in window.true_torque if each.name != "torque_error"))


def _switching_states(window: Window) -> Findings:
    states = switching_states(window.block)
    return Findings(states.measurements, states.tables)


def _residual(window: Window) -> Findings:
    return Findings(tuple(each for each in window.residual if not each.name.startswith("true_")))


def _true_residual(window: Window) -> Findings:
    return Findings(tuple(each for each in window.residual if each.name.startswith("true_")))


def _orders(window: Window, channel: str, name: str) -> Findings:
    theta_m = np.unwrap(window.block.column("theta_m"))
    if abs(float(theta_m[-1] - theta_m[0])) < _FEWEST_REVOLUTIONS * 2.0 * np.pi:
        return Findings(())
    slots = None if window.motor is None else window.motor.slots
    orders = order_analysis(window.block, channel, name, pole_pairs=window.pole_pairs, slots=slots)
    return Findings(orders.measurements, orders.tables)


def _unbalance(window: Window) -> Findings:
    return Findings(current_unbalance(window.block, window.current.track))


def _torque_lines(window: Window) -> Findings:
    lines = spectral_lines(window.block, "torque")
    return Findings(lines.measurements, lines.tables)


CORE: Final = (
    Analysis("torque ripple", ("torque",), lambda window: Findings(window.torque)),
    Analysis("torque ripple on the shaft", (), _true_torque, transducer=True),
    Analysis("error of the torque estimate", ("torque",), _torque_error, transducer=True),
    Analysis("flux ripple", ("psi_s",), _flux_ripple),
    Analysis(
        "current spectrum",
        ("i_a",),
        lambda window: Findings(window.current.measurements, window.current.tables),
    ),
    Analysis(
        "switching frequency",
        ("switching_count",),
        lambda window: Findings((switching_frequency(window.block),)),
    ),
)
"""What `analyze_steady_state` measures."""

FURTHER: Final = (
    Analysis(
        "flux trajectory",
        ("psi_alpha", "psi_beta"),
        lambda window: Findings(flux_trajectory(window.block)),
    ),
    Analysis("switching states", ("u_alpha", "u_beta", "u_dc"), _switching_states),
    Analysis("torque residual", NEEDED_TO_PREDICT, _residual, every_tick=True),
    Analysis(
        "torque residual on the shaft", NEEDED_TO_PREDICT, _true_residual, transducer=True, every_tick=True
    ),
    Analysis(
        "torque orders",
        ("theta_m", "torque"),
        lambda window: _orders(window, "torque", "torque"),
        patterns=(r"torque_order_[1-9]\d*",),
    ),
    Analysis(
        "speed orders",
        ("theta_m", "omega_m"),
        lambda window: _orders(window, "omega_m", "speed"),
        patterns=(r"speed_order_[1-9]\d*",),
    ),
    Analysis("torque spectrum", ("torque",), _torque_lines),
    Analysis("current unbalance", ("i_a", "i_b", "i_c"), _unbalance),
)
"""What channels that not every capture has give besides."""

STEADY: Final = (*CORE, *FURTHER)


@cache
def _specimen() -> Window:
    block, transducer = steady_specimen()
    return Window.of(block, SPECIMEN_MOTOR, transducer)


@cache
def step_names() -> tuple[str, ...]:
    """The names that a step response measures."""
    found = analyze_step(step_specimen(), "signal", "reference").measurements
    return tuple(each.name for each in found)


@cache
def response_names() -> tuple[str, ...]:
    """The names that a frequency response measures."""
    found = analyze_response(response_specimen(), "input", "output").measurements
    return tuple(each.name for each in found)


def analyses_of(name: str, among: Sequence[Analysis] = STEADY) -> Iterator[Analysis]:
    """The analyses that may give a measurement of that name."""
    return (each for each in among if each.measures(name))
