"""A drive: where it answers, which dictionary it speaks, what it is set to, and where its objects differ."""

from __future__ import annotations

import math
from typing import Annotated, Any, Final

from pydantic import Field, model_validator

from benchtool.document import Section

CONTROL_PERIOD_S: Final = 1e-4
"""T_s of the emulated drive, where the profile states none."""

_SHORTEST_NS, _LONGEST_NS = 25_000, 200_000  # of the emulated PWM


class Drive(Section):
    """The drive: where it answers, which dictionary it speaks and what it is set to.

    With `allow_unsupervised` it may be enabled although nothing stops it when this host falls silent.
    """

    node_id: Annotated[int, Field(ge=1, le=126)] = 1
    """CANopen node id of the drive; `&node=` of a link overrides it."""
    eds: str = "drive.eds"
    """EDS or DCF of the drive, a file beside the profile; `drive.eds` is benchtool's own dictionary."""
    allow_unsupervised: bool = False
    """Enable a drive although nothing stops it when this host falls silent; reports then say so."""
    link_timeout_s: Annotated[float, Field(ge=0.02, le=2.0)] = 0.5
    """Time without a heartbeat of this host in which the drive is to have ended the torque. Short ones need a
    host that never pauses for longer than three quarters of it."""
    prove_watchdog: bool = False
    """Prove before the first enabling of a session, and after any change of the firmware, that the drive
    notices a silent host: by being silent, with the power stage off."""
    index_search_A: Annotated[float, Field(gt=0, le=10_000)] | None = None
    """Current, peak, by which the rotor of a drive whose `encoder_reference` is the index is turned before it
    is enabled, until that has passed: a revolution within seconds, the load with it. Without it such a drive
    is not enabled before the shaft was turned by hand."""
    control_period_s: Annotated[float, Field(gt=0, le=1)] | None = None
    """Control period T_s that the drive is to have, in whole nanoseconds; an emulated drive has it, and
    100 us (10 kHz) where it is left out."""
    pwm_period_s: Annotated[float, Field(gt=0, le=1)] | None = None
    """PWM period: that of control, the default, or twice that with double update."""
    on_resistance_ohm: Annotated[float, Field(ge=0, le=100)] | None = None
    """Resistance of a conducting device of the power stage by its data sheet, with cable and plugs: it is in
    series with a phase of the winding, and in what a commissioning measures of that."""
    parameters: dict[str, float | str] = Field(default_factory=dict)
    """What the drive is set to: names of its dictionary with the unit appended, such as `u_s_V`."""

    @model_validator(mode="after")
    def _periods_fit(self) -> Drive:
        period_s, pwm_s = self.control_period_s, self.pwm_period_s
        for key, value in (("control_period_s", period_s), ("pwm_period_s", pwm_s)):
            if value is not None and not math.isclose(value, max(1, _nanoseconds(value)) * 1e-9):
                raise ValueError(f"{key} is {value:g}, a whole number of nanoseconds is expected: round it")
        if pwm_s is None:
            return self
        if period_s is None:
            raise ValueError("pwm_period_s is one or two control periods: state control_period_s as well")
        if _nanoseconds(pwm_s) not in (_nanoseconds(period_s), 2 * _nanoseconds(period_s)):
            raise ValueError(
                f"pwm_period_s is {pwm_s:g}, control_period_s {period_s:g}: one PWM period is one control "
                f"period, or two with double update"
            )
        return self

    @property
    def double_update(self) -> bool:
        """Whether control runs at both ends of a PWM period."""
        if self.pwm_period_s is None or self.control_period_s is None:
            return False
        return _nanoseconds(self.pwm_period_s) != _nanoseconds(self.control_period_s)

    @property
    def periods(self) -> dict[str, float]:
        """What is stated of them, by TOML key: the drive tells its own, and cannot be set to another."""
        stated = {"control_period_s": self.control_period_s}
        if self.control_period_s is not None:
            stated["pwm_period_s"] = self.pwm_period_s or self.control_period_s
        return {key: value for key, value in stated.items() if value is not None}


def rate_fault(pwm_period_s: float) -> str:
    """Return why the emulated drive cannot have this PWM period; empty if it can."""
    if _SHORTEST_NS <= _nanoseconds(pwm_period_s) <= _LONGEST_NS:
        return ""
    return (
        f"a PWM rate of {1e-3 / pwm_period_s:.4g} kHz, the emulated drive has {1e6 / _LONGEST_NS:g} to "
        f"{1e6 / _SHORTEST_NS:g} kHz: state a period of {_SHORTEST_NS / 1e3:g} to {_LONGEST_NS / 1e3:g} us"
    )


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)


class RoleObject(Section):
    """The object that has a role on this drive, by name or as `0x3001:2`; in a profile that text alone does.

    Where the EDS does not say what its numbers are, `raw * factor` is the value in `unit`.
    """

    object: str
    """The object that has the role, by name or as `0x3001:02`."""
    unit: str = ""
    """Unit of `raw * factor`, where the EDS does not state it."""
    factor: float = 1.0
    """Value of one raw step in `unit`."""

    @model_validator(mode="before")
    @classmethod
    def _object_alone(cls, stated: Any) -> Any:
        if not isinstance(stated, str | dict):
            raise ValueError(
                "the object as text, '0x3001:2' or its name, or a table with 'object' is expected"
            )
        return {"object": stated} if isinstance(stated, str) else stated

    @model_validator(mode="after")
    def _has_a_scale(self) -> RoleObject:
        if self.factor == 0.0:
            raise ValueError("a factor of 0 makes every value 0: state that of one raw step")
        if self.factor != 1.0 and not self.unit:
            raise ValueError("a factor is of a unit: state both")
        return self
