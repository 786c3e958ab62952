"""Modes of operation (CiA 402-2, objects 0x6060 and 0x6502) that the bench uses."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """Mode of operation. CURRENT and VOLTAGE are specific to this drive: no law runs, a stimulus sets the
    current or the voltage."""

    CURRENT = -2
    VOLTAGE = -1
    VELOCITY = 3
    TORQUE = 4

    @property
    def needs_rotor_angle(self) -> bool:
        """Whether a law that turns the rotor runs in this mode."""
        return self in (Mode.TORQUE, Mode.VELOCITY)

    @property
    def codes(self) -> tuple[int, ...]:
        """Codes that make a drive follow the same target object, the profile mode before the cyclic one."""
        return {Mode.VELOCITY: (3, 9), Mode.TORQUE: (4, 10)}.get(self, (int(self),))

    def supported_code(self, supported_modes: int) -> int | None:
        """Return the first of `codes` whose bit 0x6502 has; None if it has none of them."""
        return first_supported(self.codes, supported_modes)


PROFILE_POSITION, CYCLIC_POSITION = 1, 8


def first_supported(codes: tuple[int, ...], supported_modes: int) -> int | None:
    """Return the first of these modes that 0x6502 has; it has no bits for modes of the manufacturer, from -1
    down."""
    return next((code for code in codes if code > 0 and supported_modes >> (code - 1) & 1), None)
