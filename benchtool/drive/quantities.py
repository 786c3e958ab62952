"""Measured quantities and setpoints of a drive in SI units, from its own or standard objects.

The objects of CiA 402 have torque and current in per mille of the rated ones (0x6076 in mNm, 0x6075 in mA),
voltage in mV and speed in units of the user. A unit stated by an EDS or a profile takes precedence;
benchtool's own dictionary has each quantity as a float in SI.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from benchtool.drive.node import RemoteNode
from benchtool.errors import CapabilityMissing
from benchtool.protocol.dictionary import Dictionary, Role, Variable, spellings

_PER_MILLE: Final = 1e-3
_PER_RATED: Final = ("T_N", "I_N")  # units of the dictionary that mean: of the rated value


@dataclass(frozen=True)
class Quantity:
    """A quantity in `unit`.

    `own` is benchtool's object of it, `role` the standard's, which is in per mille of what the role `rated`
    has or, without that, in thousandths of the unit (`milli`), or in units that the standard leaves to the
    user.
    """

    title: str
    own: str
    role: Role
    rated: Role | None = None
    milli: bool = False

    @property
    def unit(self) -> str:
        """SI unit of the quantity."""
        return self.role.unit


TORQUE_SETPOINT: Final = Quantity(
    "torque setpoint", "torque_command", Role.TARGET_TORQUE, Role.MOTOR_RATED_TORQUE
)
SPEED_SETPOINT: Final = Quantity("speed setpoint", "omega_m_command", Role.TARGET_VELOCITY)
TORQUE: Final = Quantity("torque", "torque", Role.TORQUE_ACTUAL, Role.MOTOR_RATED_TORQUE)
SPEED: Final = Quantity("speed", "omega_m", Role.VELOCITY_ACTUAL)
CURRENT: Final = Quantity("current", "", Role.CURRENT_ACTUAL, Role.MOTOR_RATED_CURRENT)
DC_LINK_VOLTAGE: Final = Quantity("dc-link voltage", "u_dc", Role.DC_LINK_VOLTAGE, milli=True)
RATED_TORQUE: Final = Quantity("rated torque", "", Role.MOTOR_RATED_TORQUE, milli=True)
RATED_CURRENT: Final = Quantity("rated current", "", Role.MOTOR_RATED_CURRENT, milli=True)
_RATED: Final = {each.role: each for each in (RATED_TORQUE, RATED_CURRENT)}


def is_own(dictionary: Dictionary, quantity: Quantity) -> bool:
    """Return whether the drive has benchtool's object of it, and the profile does not redirect it."""
    own = dictionary.get(quantity.own)
    return own is not None and own.unit == quantity.unit and quantity.role not in dictionary.redirected


def in_si(node: RemoteNode, quantity: Quantity) -> Variable:
    """Return the object of a quantity, scaled so that its physical value is in `quantity.unit`.

    Of a per-mille object this reads the rated value.

    Raises:
        CapabilityMissing: the drive has no such object, or its scale is unknown.
        NoAnswer, SdoAbort: the rated value cannot be read.
    """
    dictionary = node.dictionary
    if is_own(dictionary, quantity):
        return dictionary[quantity.own]
    variable = dictionary.get(quantity.role)
    if variable is None:
        raise _unknown(node, quantity, f"has no {quantity.role.label}")
    if variable.unit in spellings(quantity.unit):
        times = float(spellings(quantity.unit)[variable.unit])
    elif quantity.rated is not None and variable.unit in ("", *_PER_RATED):
        rated = _rated(node, quantity, quantity.rated)
        times = rated if variable.unit else rated * _PER_MILLE
    elif quantity.milli and not variable.unit:
        times = _PER_MILLE
    else:
        given = f"in '{variable.unit}'" if variable.unit else "in units of its own"
        raise _unknown(node, quantity, f"has '{variable.name}' ({variable.label}) {given}")
    return replace(variable, unit=quantity.unit, factor=variable.factor * times)


def _rated(node: RemoteNode, quantity: Quantity, role: Role) -> float:
    if role not in node.dictionary:
        raise _unknown(node, quantity, f"has it in per mille, and no {role.label}")
    rated = float(node.number(in_si(node, _RATED[role])))
    if rated <= 0.0:
        raise _unknown(node, quantity, f"has it in per mille of {role.label}, which reads {rated:g}")
    return rated


def _unknown(node: RemoteNode, quantity: Quantity, seen: str) -> CapabilityMissing:
    title = quantity.role.title
    return CapabilityMissing(
        f"no {quantity.title} in {quantity.unit}: the drive of {node.dictionary.source} {seen}; say what a "
        f'raw step is in the profile, such as [roles] {title} = {{ object = "{quantity.role.address}", '
        f'unit = "{quantity.unit}", factor = 0.001 }}; nothing was sent'
    )
