"""Excitations played on a drive, and the energy that their captures show."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import Final

import numpy as np

from benchtool.block import Block
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.drive import SPEED, SPEED_SETPOINT, Capture, RemoteDrive, in_si, play
from benchtool.drive.parameters import held
from benchtool.errors import BenchError
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import Value

_PHASES: Final = ("i_a", "i_b", "i_c")
_DQ: Final = ("i_d", "i_q")
_POWER: Final = ("torque", "omega_m")
_AT_REST = 0.01  # of the rated speed
_LONGEST_BRAKING_S, _BRAKING_POLL_S = 5.0, 0.02
_SETTLES_S = 0.5  # a rotor that an alignment has let go, and cogging has pulled on


def played(drive: RemoteDrive, excitation: Excitation, known: Known) -> Block:
    """Return what was captured of one excitation; the drive is disabled when this returns or raises."""
    with ExitStack() as stack:
        stack.enter_context(held(drive, excitation.parameters))
        if excitation.standing:
            stack.enter_context(held(drive, _offset_where_it_stands(drive, known)))
        mode = excitation.power_mode
        if mode is not None:
            stack.enter_context(drive.enabled(mode))
        if mode is Mode.VELOCITY:
            drive.write(in_si(drive, SPEED_SETPOINT), excitation.omega_m_rad_s)
        if excitation.settle_s:
            drive.wait(excitation.settle_s)
        if excitation.stimulus is None:
            capture = Capture(drive, excitation.request)
            capture.wait()
            block: Block | None = capture.read()
        else:
            block = play(drive, excitation.stimulus, excitation.request, motor=known.motor)
        if mode is Mode.VELOCITY:
            _bring_to_rest(drive, known)
    if block is None:
        raise BenchError(f"the excitation '{excitation.name}' was not captured")
    return block


def _offset_where_it_stands(drive: RemoteDrive, known: Known) -> dict[str, Value]:
    """Return the encoder's offset with its eccentricity at the angle at which the rotor has come to rest.

    A degree of it is 21 electrical ones of a motor with 21 pole pairs: a current that is to lie along the
    rotor flux would make a third of its torque.
    """
    if "encoder_offset" not in known.encoder:
        return {}
    drive.wait(_SETTLES_S)
    shown = np.array([drive.number("theta_m")])
    error_rad = float(shown[0] - known.without_eccentricity(shown)[0])
    return {"encoder_offset": known.estimates["encoder_offset"].value + error_rad}


def _bring_to_rest(drive: RemoteDrive, known: Known) -> None:
    """Have the speed controller brake, so that the next excitation finds a shaft at rest; a shaft that does
    not come to rest is left to coast."""
    drive.write(in_si(drive, SPEED_SETPOINT), 0.0)
    slow_rad_s = _AT_REST * known.motor.omega_m_N_rad_s
    waited_s = 0.0
    while abs(drive.number(in_si(drive, SPEED))) > slow_rad_s and waited_s < _LONGEST_BRAKING_S:
        drive.wait(_BRAKING_POLL_S)
        waited_s += _BRAKING_POLL_S


def spent_J(excitations: Sequence[Excitation], blocks: Sequence[Block], known: Known) -> float:
    """Return heat in the winding and work against friction of captures: 3/2 R_s |i|^2, and T omega_m less
    what the rotor has of it at the end.

    An excitation whose capture has no currents counts as it was planned. What runs the shaft up before a
    capture is in neither.
    """
    R_s_ohm, J = known.R_s_ohm, known.identified.J_kgm2
    total = 0.0
    for excitation, block in zip(excitations, blocks, strict=True):
        names, row_s = block.names, block.stride * block.tick_s
        if excitation.power_mode is None:
            continue
        if set(_PHASES) <= set(names):
            squares = 2.0 / 3.0 * sum(float(np.sum(block.column(name) ** 2)) for name in _PHASES)
        elif set(_DQ) <= set(names):
            squares = sum(float(np.sum(block.column(name) ** 2)) for name in _DQ)
        else:
            total += excitation.energy_J(R_s_ohm)
            continue
        total += 1.5 * R_s_ohm * squares * row_s
        if set(_POWER) <= set(names):
            omega_m = block.column("omega_m")
            total += float(np.sum(block.column("torque") * omega_m)) * row_s
            total -= 0.5 * J * float(omega_m[-1] ** 2 - omega_m[0] ** 2)
    return total
