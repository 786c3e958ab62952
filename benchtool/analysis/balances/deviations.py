"""What is wrong with parameters that are believed: where estimates contradict them, and by how much.

An estimate contradicts a belief where it differs by more than its uncertainty makes likely (three standard
uncertainties, with few degrees of freedom as many as Student's distribution asks for) and by more than the
tolerance of commissioning: what is less is not worth a change. Where several resistances and inductances are
off by one factor, it is a gain of the sensors that explains them, not the machine.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.numbers import with_expanded
from benchtool.analysis.uncertainty import sure_of
from benchtool.profile import Motor

_RELATIVE: Final[Mapping[str, float]] = {"R_s": 0.05, "L_d": 0.03, "L_q": 0.03, "psi_r": 0.01, "J": 0.05}
_OFFSET_RAD, _OF_LINK, _GAIN, _OF_RATED = math.radians(1.0), 2e-3, 5e-3, 5e-3

_SHARED: Final[tuple[tuple[tuple[str, ...], str], ...]] = (
    (
        ("R_s", "L_d", "L_q", "psi_r"),
        "all by one factor: the gain of the dc link's voltage sensor, or the voltage that the drive assumes",
    ),
    (("R_s", "L_d", "L_q"), "all by one factor: the common gain of the current sensors"),
)


@dataclass(frozen=True)
class Deviation:
    """An estimate beside what is believed.

    `tolerance` is the least difference, in the unit of the estimate, that is worth a change; `estimate` is
    undefined where the capture does not tell it.
    """

    name: str
    believed: float
    estimate: Measurement
    tolerance: float

    @property
    def difference(self) -> float:
        """Estimate minus belief."""
        return self.estimate.value - self.believed

    @property
    def threshold(self) -> float:
        """The difference beyond which the estimate contradicts the belief."""
        return max(sure_of(self.estimate.known_uncertainty), self.tolerance)

    @property
    def told(self) -> bool:
        """Whether the capture tells it."""
        return math.isfinite(self.estimate.value)

    @property
    def contradicts(self) -> bool:
        """Whether the estimate contradicts the belief."""
        return self.told and abs(self.difference) > self.threshold

    @property
    def percent(self) -> float:
        """The difference in percent of the belief; nan of a belief of zero."""
        return 100.0 * self.difference / self.believed if self.believed else math.nan

    def __str__(self) -> str:
        """Return the deviation in words."""
        unit = self.estimate.unit
        value = f"{with_expanded(self.estimate.value, self.estimate.uncertainty)} {unit}".rstrip()
        share = f", {self.percent:+.3g} %" if math.isfinite(self.percent) else ""
        return f"{self.name} is {value}, {self.believed:.4g} {unit} is believed{share}".replace(" ,", ",")


def deviations(
    estimates: Sequence[Measurement], believed: Mapping[str, float], motor: Motor, u_dc_V: float
) -> tuple[Deviation, ...]:
    """Return each estimate beside its belief.

    Args:
        estimates: measurements whose names end with those of `believed`: `flux_balance_R_s`.
        believed: what the drive or its profile holds, by name; without an entry 0 is believed.
        motor: the rating, of which tolerances are shares.
        u_dc_V: the mean dc link, likewise.
    """
    known = (each for each in estimates if _name(each) not in _NO_PARAMETER)
    return tuple(
        Deviation(name, held, each, _tolerance(name, held, motor, u_dc_V))
        for each in known
        for name in (_name(each),)
        for held in (believed.get(name, 0.0),)
    )


def contradictions(found: Sequence[Deviation]) -> tuple[Deviation, ...]:
    """Return what contradicts its belief, the plainest first."""
    wrong = [each for each in found if each.contradicts]
    return tuple(sorted(wrong, key=lambda each: -abs(each.difference) / each.threshold))


def shared_cause(wrong: Sequence[Deviation]) -> str:
    """Return what explains several contradictions at once; empty if nothing here does."""
    by_name = {each.name: each for each in wrong}
    for names, cause in _SHARED:
        if all(name in by_name for name in names):
            ratios = [_ratio(by_name[name]) for name in names]
            if all(_agree(*pair) for pair in itertools.combinations(ratios, 2)):
                return f"{', '.join(names)} {cause}"
    return ""


def _ratio(each: Deviation) -> tuple[float, float]:
    """Return estimate over belief, and by how much that may be off."""
    return each.estimate.value / each.believed, sure_of(each.estimate.uncertainty) / abs(each.believed)


def _agree(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return abs(one[0] - other[0]) <= max(math.hypot(one[1], other[1]), _GAIN)


def _tolerance(name: str, believed: float, motor: Motor, u_dc_V: float) -> float:
    """Return the least difference that is worth a change."""
    if name in _RELATIVE:
        return _RELATIVE[name] * abs(believed)
    match name:
        case "encoder_offset":
            return _OFFSET_RAD
        case "dead_time_voltage":
            return _OF_LINK * u_dc_V
        case "friction":
            return _OF_RATED * motor.T_N_Nm / motor.omega_m_N_rad_s
        case "coulomb":
            return _OF_RATED * motor.T_N_Nm
    return _GAIN


_PREFIXES: Final = ("flux_balance_", "motion_balance_")
_NO_PARAMETER: Final = frozenset({"error_rms", "belief_error_rms"})


def _name(measurement: Measurement) -> str:
    for prefix in _PREFIXES:
        if measurement.name.startswith(prefix):
            return measurement.name.removeprefix(prefix)
    return measurement.name


def undefined(found: Sequence[Deviation]) -> Iterator[tuple[str, str]]:
    """Yield what the capture does not tell, with the reason."""
    for each in found:
        if not each.told:
            yield each.name, each.estimate.reason
