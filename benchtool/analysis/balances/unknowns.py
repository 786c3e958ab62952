"""Estimates of several unknowns from one capture: which of them it tells, and of which others it cannot tell
one apart.

Each unknown has a `span`: what it is, or could be, in a machine of this rating. Least squares are given the
weak knowledge that it lies within three spans of the belief (a prior), which keeps them bounded where the
data say nothing. An unknown whose standard uncertainty exceeds a quarter of its span is not told, nor is one
whose error goes with that of such an unknown: a correlation beyond 0.9 means that the data hardly tell the
two apart.

However small the scatter, two more are not told. Of one that is collinear with others the least error of the
model, which does not scatter, makes a large error. And of one whose excitation does not stand out of noise
that noise is taken for the excitation.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from benchtool.analysis.balances.space_vectors import Floats
from benchtool.analysis.statistics.scatter import error_of_series
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined

PRIOR_SPANS: Final = 3.0
"""Standard deviation of the prior, in spans."""

_TOLD: Final = 0.25  # of a span: the largest standard uncertainty of an unknown that is told
_INSEPARABLE: Final = 0.9  # correlation
_MOST_INFLATED: Final = 200.0  # variance by collinearity; of one torque at one speed it is 900 to 50000
ABOVE_NOISE: Final = 2.0
"""Rms of what tells an unknown, over that of its noise, from which on it is not noise that is read."""

_SINGULAR: Final = 1e-12  # of the largest eigenvalue
_BLOCKS: Final = 200
_SHORTEST: Final = 100  # rows of a block
_FEWEST_INDEPENDENT: Final = 4.0  # blocks that errors count as, however long they last

_REMEDIES: Final[Mapping[frozenset[str], str]] = {
    frozenset({"L_q", "encoder_offset"}): "a second torque",
    frozenset({"L_d", "encoder_offset"}): "a d-current",
    frozenset({"R_s", "dead_time_voltage"}): "a second level of current",
    frozenset({"R_s", "psi_r"}): "a second torque, or both directions",
    frozenset({"psi_r", "dead_time_voltage"}): "a second speed",
    frozenset({"L_d", "psi_r"}): "a d-current",
    frozenset({"psi_r", "encoder_offset"}): "a second speed",
    frozenset({"friction", "coulomb"}): "a second speed",
    frozenset({"coulomb", "load"}): "both directions",
    frozenset({"friction", "load"}): "a second speed",
    frozenset({"J", "friction"}): "faster changes of speed",
}
_ALONE: Final[Mapping[str, str]] = {
    "R_s": "more current",
    "L_d": "a d-current, or pulses along the rotor flux",
    "L_q": "steps of torque",
    "psi_r": "rotation",
    "encoder_offset": "rotation under a second torque",
    "dead_time_voltage": "several levels of current",
    "current_gain_a": "more current, over whole electrical periods",
    "current_gain_b": "more current, over whole electrical periods",
    "current_gain_c": "more current, over whole electrical periods",
    "J": "changes of speed of a shaft that turns freely",
    "friction": "several speeds",
    "coulomb": "both directions",
}


@dataclass(frozen=True)
class Solution:
    """What least squares found of unknowns.

    Attributes:
        names: of the unknowns.
        values: shape (n,).
        covariance: shape (n, n), from the scatter of the data; at least that of independent normal errors.
        spans: shape (n,).
        dof: degrees of freedom of the covariance.
        certain: covariance of independent normal errors with the prior, by which it is judged what is told.
        bias: standard uncertainty for what noise in the equations' own coefficients moves, shape (n,).
        hidden: the unknowns of which noise hides what would tell them.
    """

    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    spans: Floats
    dof: float
    certain: Floats
    bias: Floats
    hidden: frozenset[str] = frozenset()

    def value(self, name: str) -> float:
        """Return the value of an unknown."""
        return float(self.values[self.names.index(name)])

    def standard(self, name: str) -> float:
        """Return the standard uncertainty of an unknown."""
        place = self.names.index(name)
        return math.hypot(math.sqrt(float(self.covariance[place, place])), float(self.bias[place]))

    def uncertainty(self, name: str, *further: Contribution) -> Uncertainty | None:
        """Return the uncertainty of an unknown with further contributions."""
        place = self.names.index(name)
        scatter = math.sqrt(float(self.covariance[place, place]))
        lines = (
            Contribution("errors of the balance", "A", scatter, self.dof),
            Contribution("noise of the currents on both sides", "B", float(self.bias[place])),
            *further,
        )
        return combined([each for each in lines if each.standard > 0.0], _SOURCE)

    @property
    def correlation(self) -> Floats:
        """The correlations of the unknowns, shape (n, n)."""
        deviations = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(deviations, deviations))

    def given(self, name: str, value: float, standard: float) -> Solution:
        """Return the solution with one unknown known from elsewhere, to a standard uncertainty: least squares
        with one more equation (the update of a Kalman filter)."""
        place = self.names.index(name)
        updated = [self.covariance, self.certain]
        values = self.values
        for number, each in enumerate(updated):
            weight = each[:, place] / (each[place, place] + standard**2)
            if number == 0:
                values = values + weight * (value - values[place])
            updated[number] = each - np.outer(weight, each[place])
        return replace(self, values=values, covariance=updated[0], certain=updated[1])

    def told(self, name: str) -> bool:
        """Return whether the data tell an unknown, and not only together with one that they do not tell."""
        return not self.why_not(name)

    def why_not(self, name: str) -> str:
        """Return why an unknown is not told and what to play; empty if it is told."""
        place = self.names.index(name)
        others = self._inseparable(place)
        if name in self.hidden:
            return f"noise hides what would tell it in this capture: capture {_ALONE[name]}"
        if self._known(place) and self._inflation(place) <= _MOST_INFLATED:
            others = tuple(other for other in others if not self._known(self.names.index(other)))
            if not others:
                return ""
        if not others:
            return f"this capture does not tell it: capture {_ALONE.get(name, 'more excitation')}"
        remedies = (_REMEDIES.get(frozenset({name, other}), _ALONE.get(name, "")) for other in others)
        remedy = "; or ".join(dict.fromkeys(filter(None, remedies))) or "more excitation"
        return f"this capture cannot tell it from {' or '.join(others)}: capture {remedy}"

    def _known(self, place: int) -> bool:
        """Return whether the uncertainty of an unknown is small beside its span."""
        standard = max(math.sqrt(float(self.certain[place, place])), self.standard(self.names[place]))
        return standard <= _TOLD * float(self.spans[place])

    def _inflation(self, place: int) -> float:
        """Return by how much the other unknowns raise the variance of one: its variance inflation factor
        (D. W. Marquardt, Technometrics 12 (1970) 591)."""
        deviations = np.sqrt(np.diag(self.certain))
        correlation = self.certain / np.outer(deviations, deviations)
        # the gains of three phases, which add up to zero, have no inverse
        return float(np.linalg.pinv(correlation, _SINGULAR, hermitian=True)[place, place])

    def _inseparable(self, place: int) -> tuple[str, ...]:
        """Return the unknowns whose errors go with those of this one."""
        deviations = np.sqrt(np.diag(self.certain))
        correlation = self.certain[place] / (deviations[place] * deviations)
        return tuple(
            name
            for other, name in enumerate(self.names)
            if other != place and abs(correlation[other]) > _INSEPARABLE
        )


_SOURCE: Final = "scatter of the errors of the balance over blocks of the capture, with their correlation"


def solve(
    names: Sequence[str],
    rows: Floats,
    errors: Floats,
    start: Floats,
    belief: Floats,
    spans: Floats,
    *,
    block_rows: int = _SHORTEST,
) -> Solution:
    """Return a step of Gauss and Newton towards the unknowns of least squares, with the covariance there.

    The covariance of scores that are summed over blocks holds under errors that are correlated or of unequal
    variance (H. White, Econometrica 48 (1980) 817; K.-Y. Liang and S. L. Zeger, Biometrika 73 (1986) 13).

    Args:
        names: of the n unknowns.
        rows: derivatives of the model by the unknowns, shape (m, n), or (parts, m, n) for several equations
            of each instant.
        errors: measured minus model, shape (m,) or (parts, m).
        start: the unknowns at which both were computed, shape (n,).
        belief: where the prior lies, shape (n,).
        spans: of the unknowns, shape (n,).
        block_rows: least rows of a block, beyond which the covariance of errors is that of neighbouring
            blocks; of many rows they are longer rather than more.
    """
    count = len(names)
    unit = PRIOR_SPANS * spans
    equations = rows.reshape(-1, *rows.shape[-2:]) * unit
    left = errors.reshape(-1, errors.shape[-1])
    freedom = max(1, int(np.count_nonzero(left)) - count)
    variance = max(float(np.sum(left**2)) / freedom, sys.float_info.min)
    information = np.einsum("pmi,pmj->ij", equations, equations) / variance + np.eye(count)
    gradient = np.einsum("pmi,pm->i", equations, left) / variance + (belief - start) / unit
    inverse = np.linalg.inv(information)
    step = inverse @ gradient

    scores = np.einsum("pmi,pm->mi", equations, left) / variance
    size = max(block_rows, len(scores) // _BLOCKS)
    blocks = np.add.reduceat(scores, np.arange(0, len(scores), size), axis=0)
    dof = max(1.0, float(len(blocks) - count))
    moves = blocks @ inverse  # of the unknowns, by each block alone: their product has no negative variances
    robust = moves.T @ moves * (len(blocks) / dof)
    variances = np.maximum(np.diag(robust), 1e-300)
    scale = np.sqrt(np.maximum(_alike(moves), np.diag(inverse) / variances))
    covariance = robust * np.outer(scale, scale)
    units = np.outer(unit, unit)
    values = start + unit * step
    return Solution(tuple(names), values, covariance * units, spans, dof, inverse * units, np.zeros(count))


def _alike(moves: Floats) -> Floats:
    """Return by how much the variance of sums over blocks, shape (blocks, n), exceeds that of independent
    ones: errors of the encoder's disc last for longer than a block."""
    count = len(moves)
    found = np.ones(moves.shape[1])
    for place, column in enumerate(moves.T):
        error = error_of_series(column)
        if not math.isfinite(error.standard):
            found[place] = count / _FEWEST_INDEPENDENT
            continue
        independent = float(np.std(column)) / math.sqrt(max(1, count - 1))
        if independent > 0.0:
            found[place] = max(1.0, (error.experimental / independent) ** 2)
    return found
