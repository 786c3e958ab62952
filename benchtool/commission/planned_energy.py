"""The energy that excitations are to take, as far as resistance and friction are known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known


@dataclass(frozen=True)
class PlannedEnergy:
    """Heat of the winding and mechanical work in J, and between what they may be."""

    value_J: float
    least_J: float
    most_J: float


def planned_energy(excitations: Iterable[Excitation], known: Known) -> PlannedEnergy:
    """Return what excitations are to take together."""
    every = tuple(excitations)
    ranges = [each.energy_range_J(known.R_s_range_ohm) for each in every]
    return PlannedEnergy(
        sum(each.energy_J(known.R_s_ohm) for each in every),
        sum(least for least, _ in ranges),
        sum(most for _, most in ranges),
    )
