"""Densities of noise that fall towards zero frequency, as a record shows them that begins and ends anywhere.

A control with an integral leaves a signal that it holds no noise there. Beyond its bandwidth the density is
level, as f^2 / (f^2 + c^2), or falls again, as f^2 / ((c^2 - f^2)^2 + (2 zeta c f)^2): in a torque that of
the control of the speed, with little damping where it goes from count to count of an encoder. Above the crest
the noise of a lag, which is level below its corner, is much the same.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.density_bands import Densities

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_CORNERS = 2.0 ** np.arange(0.0, 12.0)  # cycles in the record, above which a density is level
_LEVELS = np.array([0.0, 2.0**-6, 2.0**-4, 2.0**-2])  # of the highest part, of white noise beside it
_CREST = 2.0 ** np.arange(1.5, 5.25, 0.5)  # cycles in the record; of fewer its fall below hardly shows
_DAMPING = np.array([0.15, 0.5, 0.98])
_KEPT = 16  # places of bands for which all are kept: many records have the same


@lru_cache(maxsize=_KEPT)
def falling_densities(places: bytes) -> tuple[Densities, Floats, Floats]:
    """Return densities at places in a record, floats, each with white noise of some levels, all together,
    shape (densities x levels, places), the variance of the mean that each makes, shape (densities, levels),
    and how probable each is before a record is seen, shape (densities,): both kinds alike."""
    at = np.append(0.0, np.frombuffer(places))
    level, again = _level_above(at, _CORNERS), _falling_again(at)
    seen = np.concatenate([level, again / np.max(again, axis=1, keepdims=True)])
    of_kind = np.concatenate([np.full(len(each), 0.5 / len(each)) for each in (level, again)])
    with_white = seen[:, np.newaxis, :] + _LEVELS[:, np.newaxis]
    return Densities(_together(with_white[:, :, 1:])), with_white[:, :, 0], of_kind


@lru_cache(maxsize=_KEPT)
def noise_of_lags(places: bytes) -> tuple[Densities, int]:
    """Return densities at places in a record, floats, of noise through a lag, with corners where others have
    crests, each with white noise of the same levels, shape (corners x levels, places), and how many levels
    these are."""
    seen = 1.0 - _level_above(np.frombuffer(places), _CREST)
    seen = seen / np.max(seen, axis=1, keepdims=True)
    return Densities(_together(seen[:, np.newaxis, :] + _LEVELS[:, np.newaxis])), len(_LEVELS)


def _together(shapes: Floats) -> Floats:
    return shapes.reshape(-1, shapes.shape[-1])


def _level_above(at: Floats, corners: Floats) -> Floats:
    """Return those that are level above their corners, shape (corners, places).

    What is missing is the noise of a first-order lag, the Fourier integral of (1 - |t|) exp(-2 pi c |t|).
    """
    turned = 2.0 * np.pi * corners[:, np.newaxis]
    return np.asarray(1.0 - turned * np.real(_over_record(turned + 2j * np.pi * at)))


def _falling_again(at: Floats) -> Floats:
    """Return those with a crest, shape (dampings x crests, places).

    Their autocovariance is exp(-zeta w |t|) (cos(v t) - zeta w / v sin(v |t|)), v = sqrt(1 - zeta^2) w.
    """
    omega = 2.0 * np.pi * _CREST
    own = np.sqrt(1.0 - _DAMPING**2)
    pole = np.outer(_DAMPING + 1j * own, omega).ravel()[:, np.newaxis]
    part = np.repeat(1.0 - 1j * _DAMPING / own, len(omega))[:, np.newaxis]
    turns = 2j * np.pi * at
    return np.asarray(np.real(part * (_over_record(pole + turns) + _over_record(pole - turns))))


def _over_record(z: Complexes) -> Complexes:
    """Return the integral of (1 - t) exp(-z t) over a record, t from 0 to 1."""
    return np.asarray(1.0 / z - (1.0 - np.exp(-z)) / z**2)
