"""Families of step and frequency responses: lags of first and second order, in noise of either colour."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import Kind, coloured, converted, noise_of
from benchmarks.coverage.true_response import sampled, true_numbers_of_response
from benchmarks.coverage.true_step import KnownStep
from benchtool.analysis import analyze_response, analyze_step
from benchtool.block import Block

Floats = NDArray[np.float64]

RATE_HZ = 10_000.0
_BEFORE_S = 0.02
_AWAY = 0.01  # of the step: from zero
_VARIED = 0.93, 1.07  # of corner and damping, from record to record


@dataclass(frozen=True)
class Lag:
    """gain x omega^2 / (s^2 + 2 damping omega s + omega^2), or gain / (1 + s / omega) without a damping."""

    corner_Hz: float
    damping: float | None = None
    gain: float = 1.0

    @property
    def omega(self) -> float:
        return 2.0 * math.pi * self.corner_Hz

    def varied(self, random: np.random.Generator) -> Lag:
        """Return one that is like it: where its corner is among the lines of a spectrum, or its peak among
        the samples, is not to be the same in all records."""
        corner_Hz = self.corner_Hz * random.uniform(*_VARIED)
        damping = None if self.damping is None else self.damping * random.uniform(*_VARIED)
        return replace(self, corner_Hz=corner_Hz, damping=damping)

    def step(self, time_s: Floats) -> Floats:
        """Return the answer to a unit step at zero, of unit gain at rest, at times of any sign."""
        x = self.omega * np.maximum(time_s, 0.0)
        if self.damping is None:
            return np.asarray(1.0 - np.exp(-x))
        decay, impulse = self._modes(x)
        return np.asarray(1.0 - decay - self.damping * impulse)

    def ramp(self, time_s: Floats, rise_s: float) -> Floats:
        """Return the answer to a unit ramp over `rise_s`."""
        return (self._integral(time_s) - self._integral(time_s - rise_s)) / rise_s

    def _integral(self, time_s: Floats) -> Floats:
        """Of the answer to a step, s."""
        x = self.omega * np.maximum(time_s, 0.0)
        if self.damping is None:
            return np.asarray((x - 1.0 + np.exp(-x)) / self.omega)
        z, (decay, impulse) = self.damping, self._modes(x)
        return np.asarray((x - 2.0 * z * (1.0 - decay) + (2.0 * z**2 - 1.0) * impulse) / self.omega)

    def _modes(self, x: Floats) -> tuple[Floats, Floats]:
        """Return exp(-z x) cosh(w x) and exp(-z x) sinh(w x) / w of the damping z, with w^2 = z^2 - 1."""
        assert self.damping is not None
        w = np.sqrt(complex(self.damping**2 - 1.0))
        slow, fast = np.exp((w - self.damping) * x), np.exp(-(w + self.damping) * x)
        impulse = x * slow if w == 0.0 else (slow - fast) / (2.0 * w)
        return np.real(slow + fast) / 2.0, np.real(impulse)

    def response(self, frequency_Hz: Floats) -> NDArray[np.complex128]:
        """Return the frequency response."""
        s = 1j * np.asarray(frequency_Hz) / self.corner_Hz
        below = 1.0 + s if self.damping is None else 1.0 + 2.0 * self.damping * s + s**2
        return np.asarray(self.gain / below)


@dataclass(frozen=True)
class Stepped:
    """One step response: `noise` is relative to the step, `rise_s` that of the reference, `delay_s` dead;
    `drift` is that over a second, relative to the step.

    The step comes up to a sample before the one that first shows it or, where a drive holds the reference
    from tick to tick, with it; which the analysis is told, unless that is `untold`.
    """

    lag: Lag
    noise: float = 1e-3
    colour: float = 0.0
    rise_s: float = 0.0
    pulse_s: float = math.inf
    delay_s: float = 0.0
    height: float = 1.0
    duration_s: float = 0.2
    held: bool = False
    untold: bool = False
    drift: float = 0.0
    kind: Kind = "white"
    of_noise: tuple[float, float] = 1.0, 1.0  # where the answer is zero, and where it is one
    gated: bool = False  # by whether the answer is away from zero, not in proportion to it
    ripple: tuple[float, float] = (0.0, 0.0)  # relative to the step, Hz
    bits: int = 0
    spikes: tuple[float, int, int] = (
        0.0,
        0,
        1,
    )  # largest height relative to the step; how many; samples of each

    def answer(self, time_s: Floats) -> Floats:
        """Return the answer without noise to a reference of 1 that begins at zero."""
        late = time_s - self.delay_s
        up = self.lag.ramp(late, self.rise_s) if self.rise_s else self.lag.step(late)
        return up - self.lag.step(late - self.pulse_s) if math.isfinite(self.pulse_s) else up

    def disturbed(self, time_s: Floats, random: np.random.Generator) -> Floats:
        """Return the answer as it is measured, but for its height and the steps of a converter."""
        noise = self.noise * coloured(noise_of(self.kind, random, len(time_s)), self.colour)
        size, ripple_Hz = self.ripple
        noise += size * np.cos(2 * np.pi * ripple_Hz * time_s + random.uniform(0, 2 * np.pi))
        largest, spikes, samples = self.spikes
        for at in random.integers(5, len(noise) - 8, spikes):
            noise[at : at + samples] += largest * random.choice([-1, 1]) * random.uniform(0.3, 1.0)
        answer = self.answer(time_s)
        away = np.abs(answer) > _AWAY if self.gated else np.abs(answer)
        at_zero, at_one = self.of_noise
        return answer + (at_zero + (at_one - at_zero) * away) * noise + self.drift * time_s


@dataclass(frozen=True)
class Excited:
    """One frequency response: `noise` of the output, and its `drift`, are relative to its own rms."""

    lag: Lag
    excitation: Literal["chirp", "prbs", "multisine", "noise"] = "chirp"
    noise: float = 1e-3
    colour: float = 0.0
    delay_s: float = 0.0
    duration_s: float = 2.0
    drift: float = 0.0
    bits: int = 0
    input_bits: int = 0
    hum: float = (
        0.0  # amplitude relative to the rms, at one of the lowest multiples of the period's frequency
    )


def stepped_trial(what: Stepped, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one step response."""
    what = replace(what, lag=what.lag.varied(random))
    row = np.arange(-round(_BEFORE_S * RATE_HZ), round(what.duration_s * RATE_HZ), dtype=np.float64)
    time_s: Floats = (row + (0.0 if what.held else random.uniform())) / RATE_HZ
    reference = np.clip(time_s / what.rise_s, 0.0, 1.0) if what.rise_s else np.where(time_s >= 0.0, 1.0, 0.0)
    if math.isfinite(what.pulse_s):
        reference = np.where(time_s >= what.pulse_s, 0.0, reference)
    measured = what.height * what.disturbed(time_s, random)
    if what.bits:
        measured = converted(measured, 2.0 * abs(what.height) / 2**what.bits, random)
    block = Block.from_arrays(
        RATE_HZ,
        {"y": "Nm", "r": "Nm"},
        y=measured,
        r=what.height * reference,
    )
    found = analyze_step(block, "y", "r", held=what.held and not what.untold).measurements
    known = KnownStep(
        what.answer,
        time_s,
        reference,
        partial(what.disturbed, time_s, random),
        what.height,
        0.5 * what.rise_s,
        tuple(what.delay_s + each for each in (0.0, what.rise_s, what.pulse_s)),
        what.drift,
    )
    yield from selected(found, known.true_numbers(found))


def excited_trial(what: Excited, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one frequency response; the system runs in continuous time, its input is held."""
    what = replace(what, lag=what.lag.varied(random))
    count = round(what.duration_s * RATE_HZ)
    period = None
    if what.excitation == "chirp":
        time_s = np.arange(count) / RATE_HZ
        x = signal.chirp(time_s, 2.0, what.duration_s, 2_000.0, "logarithmic", phi=random.uniform(0, 360))
    elif what.excitation == "prbs":
        bits, _ = signal.max_len_seq(10, state=random.integers(0, 2, 10) | np.eye(10, dtype=int)[0])
        period = 2 * len(bits)
        x = np.resize(np.repeat(2.0 * bits - 1.0, 2), count + period)
    elif what.excitation == "multisine":
        period = 2000
        lines = np.unique(np.geomspace(1.0, 400.0, 60).round().astype(int))
        bins = np.zeros(period // 2 + 1, dtype=np.complex128)
        bins[lines] = np.exp(2j * np.pi * random.random(len(lines)))
        x = np.resize(np.fft.irfft(bins) * period / len(lines), count + period)
    else:
        x = random.standard_normal(count)
    x = np.asarray(x, dtype=np.float64)
    y = _held(what.lag, x)
    late = round(what.delay_s * RATE_HZ)
    y = np.concatenate([np.zeros(late), y[: len(y) - late]])
    rms = float(np.std(y))
    y += what.noise * rms * coloured(random.standard_normal(len(y)), what.colour)
    y += what.drift * rms * np.linspace(0.0, 1.0, len(y))
    if what.hum and period:
        turn = 2.0 * math.pi * int(random.integers(5, 150)) / period
        y += what.hum * rms * np.cos(turn * np.arange(len(y)) + random.uniform(0.0, 2.0 * math.pi))
    if what.bits:
        y = converted(y, 2.2 * float(np.max(np.abs(y))) / 2**what.bits, random)
    if what.input_bits:
        x = converted(x, 2.2 * float(np.max(np.abs(x))) / 2**what.input_bits, random)
    block = Block.from_arrays(RATE_HZ, {"x": "Nm", "y": "Nm"}, x=x, y=y)
    found = analyze_response(block, "x", "y", begin_row=period or 0, period_rows=period).measurements
    above, below = discrete(what.lag)
    response = sampled(np.concatenate([np.zeros(late), above]), below, RATE_HZ)
    yield from selected(found, true_numbers_of_response(response, 0.5 * RATE_HZ, found))


@dataclass(frozen=True)
class Looped:
    """An integrator with a dead time behind unity feedback, excited by noise; `noise` of the output."""

    crossover_Hz: float = 150.0
    delay_rows: int = 6
    noise: float = 1e-3
    colour: float = 0.0
    duration_s: float = 4.0


def looped_trial(what: Looped, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the stability margins of one closed loop."""
    gain, rows = 2.0 * math.pi * what.crossover_Hz / RATE_HZ, what.delay_rows
    ahead, behind = np.zeros(rows + 1), np.zeros(rows + 1)
    behind[:2], ahead[rows] = (1.0, -1.0), gain
    x = random.standard_normal(round(what.duration_s * RATE_HZ))
    y = np.asarray(signal.lfilter(ahead, behind + ahead, x))
    y += what.noise * float(np.std(y)) * coloured(random.standard_normal(len(y)), what.colour)
    block = Block.from_arrays(RATE_HZ, {"x": "Nm", "y": "Nm"}, x=x, y=y)
    found = analyze_response(block, "x", "y").measurements
    closed = sampled(ahead, behind + ahead, RATE_HZ)
    yield from selected(found, true_numbers_of_response(closed, 0.5 * RATE_HZ, found))


def _held(lag: Lag, x: Floats) -> Floats:
    """Return the samples of the answer to an input that is held from sample to sample, from rest."""
    numerator, denominator = discrete(lag)
    return np.asarray(signal.lfilter(numerator, denominator, x))


def discrete(lag: Lag) -> tuple[Floats, Floats]:
    """Return the coefficients of a lag whose input is held from sample to sample."""
    omega = lag.omega
    below = [1.0, omega] if lag.damping is None else [1.0, 2.0 * lag.damping * omega, omega**2]
    system = (np.array([lag.gain * below[-1]]), np.array(below))
    numerator, denominator, _ = signal.cont2discrete(system, 1.0 / RATE_HZ, "zoh")
    return np.ravel(numerator), np.ravel(denominator)


_FIRST, _SECOND, _SOFT = Lag(80.0), Lag(60.0, 0.4), Lag(60.0, 0.75)
STEPPED: Mapping[str, Stepped] = {
    **{
        f"step_{name}_{noise}dB{hue}": Stepped(lag, 10 ** (noise / 20), colour)
        for name, lag in (("lag1", _FIRST), ("lag2", _SECOND))
        for noise in (-80, -60, -46, -34)
        for hue, colour in (("", 0.0), ("_coloured", 0.9))
    },
    "step_soft": Stepped(_SOFT, 1e-2),
    "step_delayed": Stepped(_SECOND, 3e-3, delay_s=1.37e-3),
    "step_down": Stepped(_SECOND, 3e-3, height=-2.0),
    "step_slow": Stepped(Lag(15.0), 1e-2),
    "pulse_lag1": Stepped(_FIRST, 3e-3, pulse_s=0.08),
    "pulse_lag2": Stepped(_SECOND, 1e-2, pulse_s=0.08),
    "ramp_lag1": Stepped(_FIRST, 3e-3, rise_s=0.02),
    "ramp_lag2": Stepped(_SECOND, 1e-2, rise_s=0.01),
    "ramp_kinked": Stepped(Lag(200.0, 0.9), 1e-3, rise_s=0.03),
    "ramp_noisy": Stepped(_FIRST, 5e-2, rise_s=0.03),
    "step_held": Stepped(_SECOND, 1e-3, held=True),
    "step_with_its_row": Stepped(Lag(50.0), 3e-3, held=True, untold=True),
    "step_held_lag1": Stepped(_FIRST, 1e-2, held=True),
    "step_held_coloured": Stepped(_SOFT, 3e-3, 0.9, held=True),
    **{
        f"step_drifting_{drift:g}": Stepped(lag, 3e-3, colour, drift=drift)
        for drift, lag, colour in (
            (0.01, _SECOND, 0.0),
            (0.3, _SECOND, 0.0),
            (-0.3, _FIRST, 0.9),
            (2.0, _FIRST, 0.0),
        )
    },
    "step_underdamped": Stepped(Lag(150.0, 0.15), 3e-3, 0.9),
    "step_pink": Stepped(_SECOND, 1e-2, kind="pink"),
    "step_lag1_pink": Stepped(_FIRST, 1e-2, kind="pink"),
    "ramp_pink": Stepped(_SECOND, 1e-2, kind="pink", rise_s=0.02, held=True),
    "step_ripple": Stepped(_SECOND, 2e-3, ripple=(0.02, 731.0), held=True),
    "step_lag1_ripple": Stepped(_FIRST, 2e-3, ripple=(0.03, 431.0)),
    "step_bits_8": Stepped(_SECOND, 1e-4, bits=8, held=True),
    "step_lag1_bits_7": Stepped(_FIRST, 1e-4, bits=7, held=True),
    "step_slow_coloured": Stepped(Lag(20.0), 2e-2, 0.95, pulse_s=0.1),
}
EXCITED: Mapping[str, Excited] = {
    **{
        f"{excitation}_{name}_{noise}dB": Excited(lag, excitation, 10 ** (noise / 20))
        for excitation in ("chirp", "prbs", "multisine", "noise")
        for name, lag in (("lag1", Lag(100.0, gain=2.0)), ("lag2", Lag(200.0, 0.35)))
        for noise in (-80, -40, -20)
    },
    **{
        f"multisine_{corner_Hz}Hz_{damping}_{noise}dB": Excited(
            Lag(corner_Hz, damping), "multisine", 10 ** (noise / 20)
        )
        for corner_Hz, damping in ((150.0, 0.5), (120.0, 0.2), (300.0, 0.7), (250.0, 0.3), (350.0, 0.45))
        for noise in (-25, -60)
    },
    "chirp_coloured": Excited(Lag(100.0), "chirp", 3e-2, colour=0.95),
    "prbs_coloured": Excited(Lag(200.0, 0.35), "prbs", 3e-2, colour=0.95),
    "noise_coloured": Excited(Lag(200.0, 0.7), "noise", 3e-2, colour=0.95),
    "prbs_hum": Excited(Lag(300.0, 0.4), "prbs", 1e-2, hum=0.03),
    "chirp_input_bits_5": Excited(Lag(300.0), "chirp", 1e-2, input_bits=5),
    "multisine_input_bits_6": Excited(Lag(300.0), "multisine", 1e-2, input_bits=6),
    "multisine_input_bits_8": Excited(Lag(300.0, 0.4), "multisine", 1e-2, input_bits=8),
    "chirp_delayed": Excited(Lag(300.0), "chirp", 1e-2, delay_s=4e-4),
    "prbs_delayed": Excited(Lag(300.0), "prbs", 1e-2, delay_s=4e-4),
    **{
        f"{excitation}_drifting": Excited(Lag(100.0), excitation, 1e-2, drift=0.3)
        for excitation in ("chirp", "prbs", "multisine", "noise")
    },
    **{
        f"{excitation}_resonant": Excited(Lag(60.0, 0.1), excitation, 3e-3)
        for excitation in ("chirp", "multisine", "noise")
    },
}


LOOPED: Mapping[str, Looped] = {
    "loop": Looped(),
    "loop_noisy": Looped(noise=0.05),
    "loop_coloured": Looped(noise=0.02, colour=0.95, delay_rows=3),
    "loop_fast": Looped(crossover_Hz=300.0, delay_rows=4, noise=0.01),
}


FAMILIES = (
    *families_of(stepped_trial, STEPPED),
    *families_of(excited_trial, EXCITED),
    *families_of(looped_trial, LOOPED),
)
