"""Harmonics of the rotor's flux linkage, from captures of a turning motor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Contribution, Measurement, combined
from benchtool.block import Block
from benchtool.commission.estimators.flux_linkage import HARMONICS, TurningFlux, harmonics, rotor_flux
from benchtool.commission.estimators.vectors import vector_of
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS


def flux_harmonics(
    blocks: Sequence[Block],
    turning: Sequence[TurningFlux],
    moved: Sequence[TurningFlux],
    known: Known,
    rounded_Wb: float,
    across_Wb: float,
) -> Iterator[Measurement]:
    """Yield the harmonics of the rotor flux, mean over the captures, in the frame of the encoder's angle.

    What dead time and devices take where a phase current goes through zero comes there at each sixth of a
    revolution of the flux, and along the EMF: the voltages of all these orders are off by as much as the
    fundamental, and the fluxes by less, as each turns faster. An angle that is off turns each harmonic.

    Args:
        blocks, turning: the captures, and what they tell.
        moved: what they tell with another share of dead time.
        known: before this step.
        rounded_Wb: what the fundamental may be off by, by dead time near zero current.
        across_Wb: what it may be off by, by dead time, of a current that is all across the flux.
    """
    offset = known.estimates.get("encoder_offset")
    aside_rad = 0.0
    if offset is not None and offset.uncertainty is not None:
        aside_rad = known.identified.pole_pairs * offset.uncertainty.standard
    found, other = (_of_captures(blocks, each, known) for each in (turning, moved))
    harmonic_A, whole_A = _currents_A(blocks, turning, known)
    of_inductances_Wb = _unsure_L_H(known) * harmonic_A
    across_Wb *= harmonic_A / whole_A
    for order in HARMONICS:
        z, with_share = found[order], complex(np.mean(other[order]))
        mean = complex(np.mean(z))
        turned_Wb = abs(order) * aside_rad
        # an angle that goes to and fro by a shows J_0(n a) of a harmonic, 1 - (n a)^2 / 4
        lost = 0.25 * (order * known.identified.pole_pairs * known.eccentricity_left_rad) ** 2
        parts = (
            ("cos", z.real, mean.real, with_share.real, mean.imag, rounded_Wb),
            ("sin", z.imag, mean.imag, with_share.imag, mean.real, 0.0),
        )
        for part, values, value, by_share, other_Wb, along_EMF_Wb in parts:
            lines = [
                scatter_of(values),
                Contribution("dead time near zero current", "B", along_EMF_Wb / abs(order)),
                Contribution("dead time of the harmonics' currents", "B", across_Wb / abs(order)),
                Contribution("dead time and devices, their shares", "A", abs(by_share - value)),
                Contribution("offset of the encoder", "B", turned_Wb * abs(other_Wb)),
                Contribution("inductances", "B", of_inductances_Wb),
                Contribution("eccentric encoder", "B", abs(value) * lost / math.sqrt(3.0)),
            ]
            yield Measurement(
                f"psi_{abs(order)}_{part}",
                value,
                "Wb",
                f"{part} part of the rotor flux that turns {order} times as fast as the rotor",
                uncertainty=combined(lines, "scatter over speeds and directions"),
            )


def _of_captures(
    blocks: Sequence[Block], turning: Sequence[TurningFlux], known: Known
) -> dict[int, NDArray[np.complex128]]:
    """Return the harmonics of the rotor flux by their orders, of each capture, shapes (n,)."""
    found, saliency_H = [], known.identified.L_d_H - known.identified.L_q_H
    for block, each in zip(blocks, turning, strict=True):
        theta_e, i_A = _seen(block, each, known)
        found.append(harmonics(rotor_flux(each.active_Wb, i_A, theta_e, saliency_H), theta_e))
    return {order: np.array([each[order] for each in found]) for order in HARMONICS}


def _seen(block: Block, of: TurningFlux, known: Known) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Return the electrical angle by the encoder, and the current, of the rows that were used."""
    theta_e = known.identified.pole_pairs * known.without_eccentricity(angle_of(block))
    i_A = vector_of(np.column_stack([block.column(name) for name in CURRENTS])[1:])
    return theta_e[of.rows], i_A[of.rows]


def _currents_A(blocks: Sequence[Block], turning: Sequence[TurningFlux], known: Known) -> tuple[float, float]:
    """Return the rms over the captures of the currents that the harmonics of the rotor flux drive, peak, and
    of the whole current."""
    squares, whole = [], []
    for block, each in zip(blocks, turning, strict=True):
        theta_e, i_A = _seen(block, each, known)
        squares.append(sum(abs(wave) ** 2 for wave in harmonics(i_A, theta_e).values()))
        whole.append(float(np.mean(np.abs(i_A) ** 2)))
    return math.sqrt(float(np.mean(squares))), math.sqrt(float(np.mean(whole)))


def _unsure_L_H(known: Known) -> float:
    """Return the standard uncertainty of the inductance that is known less well."""
    of_both = (known.estimates.get(name) for name in ("L_d", "L_q"))
    return max(
        (each.uncertainty.standard for each in of_both if each is not None and each.uncertainty is not None),
        default=0.0,
    )


def scatter_of(values: NDArray[np.float64]) -> Contribution:
    """Return the contribution of the scatter of the captures to their mean."""
    standard = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return Contribution("scatter over speeds and directions", "A", standard, len(values) - 1.0)


def angle_of(block: Block) -> NDArray[np.float64]:
    """Return the mechanical angle by the encoder at the ends of the periods of a capture, shape (n,)."""
    unwrapped: NDArray[np.float64] = np.unwrap(block.column("theta_m"))[1:]
    return unwrapped
