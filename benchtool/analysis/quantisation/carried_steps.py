"""Errors of a converter's steps in what repeats while slow lines or a drift carry it over the steps.

From period to period the waveform is read in other parts of the steps, and errors average out; not all of
them, as a sinusoid of A dwells at its ends: of sin(2 pi k x / q) it leaves J_0(2 pi k A / q) (Widrow and
Kollar, Quantization Noise, 2008, of sinusoids). No scatter shows what is left, and it is no error that is
alike in every period either: it is looked up along the record.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.repeated_steps import (
    Repeated,
    RepeatedSteps,
    error_of_steps,
    noise_beside,
)

_DRAWS = 32  # of where the levels lie, and of sizes
_APART = 0.1  # of a step, rms: how much the sizes of two of them differ
_STANDS_OUT = 4.0  # of the noise's rms amplitude
_MOST_ROWS = 1 << 15

Floats = NDArray[np.float64]


def are_carried(carried: Floats, step: float) -> bool:
    """Return whether what carries a waveform, shape (n,), takes it to another part of the steps."""
    return step > 0.0 and float(np.std(carried)) > _APART * step


def carried_steps(
    samples: Floats, carried: Floats, begins: NDArray[np.int64], step: float, turns: Floats
) -> RepeatedSteps | None:
    """Return the errors along samples, shape (n,), which are of what repeats in periods, of what `carried`
    it, shape (n,), and of noise; None where this hides them.

    `begins`, shape (periods + 1,), are the rows at which periods begin, `turns`, shape (n,), is where samples
    are, in periods.
    """
    still = Repeated.of(samples - carried, begins, turns)
    noise_rms = 2.0 * float(np.std(samples - carried)) / math.sqrt(len(samples))
    orders = np.flatnonzero(np.abs(still.phasors) > max(_STANDS_OUT * noise_rms, _APART * step))
    rows = slice(None, None, -(-len(samples) // _MOST_ROWS))
    waves = np.exp(2j * np.pi * np.outer(turns[rows], orders + 1))
    waveform = still.mean + np.real(waves @ still.phasors[orders])
    left = float(np.mean((samples[rows] - waveform - carried[rows]) ** 2))
    noise = noise_beside(min(left, still.noise2), step)
    random = np.random.default_rng(0)
    relative = _APART * step / float(np.std(carried))
    errors = []
    for level in step * np.arange(_DRAWS) / _DRAWS:
        more = _APART * step * (random.standard_normal((2, len(orders))).T @ np.array([1.0, 1j]))
        signal = (
            waveform + np.real(waves @ more) + carried[rows] * (1.0 + relative * random.standard_normal())
        )
        error = error_of_steps(signal, step, noise, level)
        if error is None:
            return None
        errors.append(error)
    return RepeatedSteps(waveform + carried[rows], np.array(errors), 1)
