"""Families of frequency responses whose input is not clean: noise that a loop feeds back to it or that its
sensor adds, few lines, a period that is not stated, rests at both ends, answers that noise hides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.dynamic import RATE_HZ, Lag, discrete
from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.true_response import sampled, true_numbers_of_response
from benchtool.analysis import analyze_response
from benchtool.block import Block

Floats = NDArray[np.float64]

_PERIOD = 2000  # samples
_PERIODS = 6
_RESTS = 0.04  # of a sweep, at either end


@dataclass(frozen=True)
class Identified:
    """A lag and how it is excited; it answers `dead` samples late.

    `noise` is of the output and `input_noise` of the measured input, relative to the stimulus; `drift` is
    that of the output over the record. With a `controller` gain the stimulus is the reference of a loop about
    the lag, the input what the controller gives, and the noise goes around; `by_stimulus` where its channel
    is named.
    """

    lag: Lag
    dead: int = 1
    excitation: Literal["lines", "few lines", "sweep", "sweep to the ends", "noise"] = "lines"
    top_Hz: float = 1500.0
    noise: float = 1e-2
    input_noise: float = 0.0
    drift: float = 0.0
    controller: float = 0.0
    by_stimulus: bool = False
    is_declared: bool = True
    duration_s: float = 2.0

    @property
    def filter(self) -> tuple[Floats, Floats]:
        """Coefficients of the sampled lag, of unit gain at rest."""
        numerator, denominator = discrete(self.lag)
        late = np.zeros(self.dead - 1)
        return np.concatenate([late, numerator]), np.concatenate([denominator, late])

    def stimulus(self, random: np.random.Generator) -> Floats:
        """Return samples of unit rms."""
        if self.excitation in ("lines", "few lines"):
            last = round(self.top_Hz * _PERIOD / RATE_HZ)
            lines = np.arange(1, last + 1)
            if self.excitation == "few lines":
                lines = np.unique(np.geomspace(1.0, last, 13).round().astype(int))
            bins = np.zeros(_PERIOD // 2 + 1, dtype=np.complex128)
            bins[lines] = np.exp(2j * np.pi * random.random(len(lines)))
            x = np.tile(np.fft.irfft(bins), _PERIODS + 1)
        elif self.excitation == "noise":
            x = random.standard_normal(round(self.duration_s * RATE_HZ))
        else:
            count = round(self.duration_s * RATE_HZ)
            rest = round(_RESTS * count) if self.excitation == "sweep" else 0
            time_s = np.arange(count - 2 * rest) / RATE_HZ
            sweep = signal.chirp(time_s, 2.0, time_s[-1], self.top_Hz, phi=-90.0)
            x = np.pad(sweep * signal.windows.tukey(len(sweep), 0.02), rest) if rest else sweep
        return np.asarray(x / np.std(x))


def identified_trial(what: Identified, random: np.random.Generator) -> Iterator[Compared]:
    """Yield the numbers of one record."""
    what = replace(what, lag=what.lag.varied(random))
    numerator, denominator = what.filter
    stimulus = what.stimulus(random)
    disturbance = what.noise * random.standard_normal(len(stimulus))
    disturbance += what.drift * np.linspace(0.0, 1.0, len(stimulus))
    if what.controller:
        opened = what.controller * numerator
        around = opened + denominator
        y = signal.lfilter(opened, around, stimulus) + signal.lfilter(denominator, around, disturbance)
        x = what.controller * (stimulus - y)
    else:
        y = signal.lfilter(numerator, denominator, stimulus) + disturbance
        x = stimulus
    x = x + what.input_noise * random.standard_normal(len(x))
    block = Block.from_arrays(
        RATE_HZ, {"x": "Nm", "y": "Nm", "r": "Nm"}, x=np.asarray(x), y=np.asarray(y), r=stimulus
    )
    repeats = what.excitation in ("lines", "few lines")
    found = analyze_response(
        block,
        "x",
        "y",
        begin_row=_PERIOD if repeats else 0,
        period_rows=_PERIOD if repeats and what.is_declared else None,
        stimulus="r" if what.by_stimulus else None,
    ).measurements
    response = sampled(numerator, denominator, RATE_HZ)
    yield from selected(found, true_numbers_of_response(response, 0.5 * RATE_HZ, found))


_SLOW = Lag(90.0)
FAMILIES = families_of(
    identified_trial,
    {
        "fed_back_lines": Identified(Lag(110.0), controller=2.5, noise=0.03, top_Hz=1800.0),
        "fed_back_lines_noisy": Identified(Lag(110.0), controller=2.5, noise=0.25, top_Hz=1800.0),
        "fed_back_few_lines": Identified(Lag(140.0), controller=2.0, noise=0.1, excitation="few lines"),
        "input_noise_lines": Identified(Lag(120.0), input_noise=0.4),
        "input_noise_resonant": Identified(Lag(220.0, 0.4), input_noise=0.2),
        "few_lines": Identified(Lag(180.0, 0.35), excitation="few lines", noise=0.02),
        "few_lines_exact": Identified(Lag(180.0, 0.45), excitation="few lines", noise=0.0),
        "few_lines_lag": Identified(Lag(130.0), dead=2, excitation="few lines", noise=0.01),
        "undeclared_few_lines": Identified(
            Lag(130.0), dead=2, excitation="few lines", noise=0.03, is_declared=False
        ),
        "undeclared_lines": Identified(Lag(120.0), noise=0.05, is_declared=False),
        "sweep_rest_drifting": Identified(Lag(120.0), dead=2, excitation="sweep", drift=0.25),
        "sweep_rest_hidden": Identified(Lag(150.0, 0.7), dead=2, excitation="sweep", noise=0.25),
        "sweep_rest_low": Identified(Lag(45.0), dead=3, excitation="sweep", top_Hz=160.0, duration_s=0.6),
        "lines_hidden": Identified(Lag(180.0, 0.75), noise=0.12),
        "input_noise_sweep": Identified(Lag(120.0), input_noise=0.12, excitation="sweep"),
        **{
            f"fed_back_{name}": replace(what, by_stimulus=is_named)
            for suffix, is_named in (("", False), ("_stimulus", True))
            for name, what in (
                (f"sweep{suffix}", Identified(Lag(110.0), 1, "sweep", controller=2.5, noise=0.12)),
                (
                    f"sweep_to_ends{suffix}",
                    Identified(_SLOW, 1, "sweep to the ends", 900.0, 0.15, controller=4.0),
                ),
                (f"sweep_quiet{suffix}", Identified(_SLOW, 2, "sweep", controller=1.5, noise=2e-3)),
            )
        },
        "fed_back_lines_stimulus": Identified(Lag(110.0), controller=2.5, noise=0.3, by_stimulus=True),
        "fed_back_undeclared_stimulus": Identified(
            Lag(130.0), 1, "few lines", noise=0.1, controller=2.0, is_declared=False, by_stimulus=True
        ),
        "fed_back_noise_stimulus": Identified(
            Lag(110.0), 1, "noise", noise=0.2, controller=3.0, duration_s=3.0, by_stimulus=True
        ),
        "fed_back_resonant_stimulus": Identified(
            Lag(150.0, 0.3), 2, "noise", noise=0.05, controller=0.6, duration_s=3.0, by_stimulus=True
        ),
        "noise_lag_high": Identified(Lag(2_800.0), excitation="noise", noise=0.03, duration_s=1.2),
    },
)
