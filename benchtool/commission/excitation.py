"""One excitation: what the drive plays and captures meanwhile, and the energy that it takes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from benchtool.drive import CaptureRequest, Stimulus
from benchtool.errors import ValueRefused
from benchtool.profile import Motor
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import Value

MOST_RISE_K: Final = 10.0
"""By how much a step may warm the winding."""

OVERLOAD: Final = 1.1
"""Of the rated current, what is injected at most."""

_FRICTION_AS_TAKEN: Final = (0.25, 3.0)  # over what is taken for it before it was measured
_RATED_RISE_K: Final = 100.0  # at the rated current for ever, of insulation class F (IEC 60034-1: 105 K)
_TIME_CONSTANT_S: Final = 60.0  # of a winding against its iron: of a small motor, the shortest that is usual


@dataclass(frozen=True)
class Excitation:
    """A stimulus or none, what is captured, and parameters held meanwhile.

    `squares_A2s` is the integral of the squared length of the current vector that is expected, `work_J` the
    mechanical energy. The drive is enabled in `mode`, by default that of the stimulus, and not at all without
    either. `omega_m_rad_s` and `settle_s` are a speed that it runs at in velocity mode, and how long it takes
    to get there, before it plays and captures. `standing`, the rotor is to stand meanwhile, and the drive to
    know its angle without the encoder's eccentricity. `most_times` is how often it is played at most, where
    what it shows may have it played again.
    """

    name: str
    stimulus: Stimulus | None
    request: CaptureRequest
    squares_A2s: float = 0.0
    parameters: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))
    omega_m_rad_s: float = 0.0
    settle_s: float = 0.0
    work_J: float = 0.0
    mode: Mode | None = None
    standing: bool = False
    most_times: int = 1

    def energy_J(self, R_s_ohm: float) -> float:
        """Return the heat in the winding, 3/2 R_s times the integral, and the mechanical work."""
        return 1.5 * R_s_ohm * self.squares_A2s + self.work_J

    def energy_range_J(self, R_s_range_ohm: tuple[float, float]) -> tuple[float, float]:
        """Return the least and the most that it may be as long as resistance and friction are not known, nor
        how often it is played."""
        least, most = (
            self.energy_J(R_s_ohm) + (share - 1.0) * self.work_J
            for R_s_ohm, share in zip(R_s_range_ohm, _FRICTION_AS_TAKEN, strict=True)
        )
        return least, self.most_times * most

    @property
    def mode_of_speed(self) -> bool:
        """Whether the shaft turns on and on."""
        return self.power_mode is Mode.VELOCITY

    @property
    def power_mode(self) -> Mode | None:
        """Mode in which the drive is enabled; None with the power stage off."""
        if self.mode is not None or self.stimulus is None:
            return self.mode
        return self.stimulus.modes[-1]  # a d-current plays at a speed


def require_bearable(excitations: Iterable[Excitation], motor: Motor) -> None:
    """Check the heat of a step by I2t: at most 10 K if none of it left the winding.

    A winding that the rated current warms by 100 K with a time constant of 60 s takes 1.67 K/s at first, in
    proportion to the square of the current.

    Raises:
        ValueRefused: it is too much; nothing was sent.
    """
    squares = sum(each.squares_A2s for each in excitations)
    rise_K = squares / (2.0 * motor.I_N_A_rms**2) * _RATED_RISE_K / _TIME_CONSTANT_S
    if rise_K > MOST_RISE_K or not math.isfinite(rise_K):
        raise ValueRefused(
            f"the step would warm the winding by {rise_K:.3g} K, at most {MOST_RISE_K:g} K is allowed: lower "
            f"its current or its duration; nothing was sent"
        )
