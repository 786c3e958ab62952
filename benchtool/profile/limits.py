"""The `[limits]` section of a profile: what is supervised by the host while a drive is enabled."""

from __future__ import annotations

from benchtool.document import Section
from benchtool.profile.motor import Positive


class Limits(Section):
    """Limits that the host looks at while the drive is enabled, in its stream; beyond one it stops the motor.

    A drive that does not stream what is limited is not enabled.
    A host is slower than the drive, whose own trip levels come first; these are for what a test must not
    reach, and for what a drive does not look at.
    """

    torque_Nm: Positive | None = None
    """Torque that the drive estimates, either way."""
    current_A: Positive | None = None
    """Phase currents, peak, either way."""
    current_sum_A: Positive | None = None
    """Sum of the three phase currents, either way; what a wrong current sensor makes."""
    current_unbalance_percent: Positive | None = None
    """Difference between the largest and the smallest rms of the phase currents, of the largest, over 0.4 s
    in which the shaft turns; what an open phase makes."""
    omega_m_rad_s: Positive | None = None
    """Mechanical speed, either way."""
    temperature_degC: Positive | None = None
    """Temperature of the winding, as the thermometer of the bench reads it."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Signals of the stream that these limits need."""
        needed: list[str] = []
        if self.torque_Nm is not None:
            needed.append("torque")
        if self.omega_m_rad_s is not None or self.current_unbalance_percent is not None:
            needed.append("omega_m")
        if any((self.current_sum_A, self.current_A, self.current_unbalance_percent)):
            needed += ["i_a", "i_b", "i_c"]
        return tuple(needed)
