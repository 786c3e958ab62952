"""The search for an encoder's index: the drive drags the rotor round in current mode until it has passed."""

from __future__ import annotations

import math
from typing import Final

from benchtool.drive.player import play
from benchtool.drive.remote import ANGLE_KNOWN, RemoteDrive
from benchtool.drive.stimulus import Stimulus
from benchtool.errors import StateError
from benchtool.profile import Motor
from benchtool.protocol import Mode

_REVOLUTIONS: Final = 1.1
_REVOLUTION_S: Final = 2.0
_TURN_S: Final = 0.2  # in which the vector comes up to speed, and to rest


def find_index(drive: RemoteDrive, motor: Motor, current_A: float) -> None:
    """Turn the rotor with a current vector by a revolution until the encoder's index has passed; one that
    stood at a stop is turned the other way then. The drive is disabled when this returns or raises.

    Args:
        drive: connected; its angle is not known.
        motor: whose rating the current must stay within.
        current_A: length of the vector, peak, that draws the rotor along.

    Raises:
        StateError: no index has passed.
        ValueRefused, CapabilityMissing, SdoAbort, StimulusError, DriveFault: as `play`.
    """
    for direction in (1.0, -1.0):
        with drive.enabled(Mode.CURRENT):
            play(drive, _dragging(motor, direction, current_A), motor=motor)
        if drive.optional_number(ANGLE_KNOWN) != 0:
            return
    raise StateError(
        f"the encoder's index has not passed while a current of {current_A:g} A turned the rotor by a "
        f"revolution to either side: raise drive.index_search_A of the profile if the shaft did not follow, "
        f"check the cable of the index, or set encoder_reference to 'absolute'; the drive is disabled"
    )


def _dragging(motor: Motor, direction: float, current_A: float) -> Stimulus:
    return Stimulus(
        quantity="current",
        shape="constant",
        amplitude_A=current_A,
        duration_s=_REVOLUTIONS * _REVOLUTION_S + _TURN_S,
        omega_e_rad_s=direction * motor.pole_pairs * 2.0 * math.pi / _REVOLUTION_S,
        turn_s=_TURN_S,
    )
