"""Excitations played on a drive, and the energy that their captures show."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import Final

import numpy as np

from benchtool.block import Block
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.drive import SPEED_SETPOINT, Capture, RemoteDrive, in_si, play
from benchtool.drive.parameters import held
from benchtool.errors import BenchError

_PHASES: Final = ("i_a", "i_b", "i_c")
_DQ: Final = ("i_d", "i_q")
_POWER: Final = ("torque", "omega_m")


def played(drive: RemoteDrive, excitation: Excitation, known: Known) -> Block:
    """Return what was captured of one excitation; the drive is disabled when this returns or raises."""
    with ExitStack() as stack:
        stack.enter_context(held(drive, excitation.parameters))
        mode = excitation.power_mode
        if mode is not None:
            stack.enter_context(drive.enabled(mode))
        if excitation.omega_m_rad_s:
            drive.write(in_si(drive, SPEED_SETPOINT), excitation.omega_m_rad_s)
        if excitation.settle_s:
            drive.wait(excitation.settle_s)
        if excitation.stimulus is None:
            capture = Capture(drive, excitation.request)
            capture.wait()
            return capture.read()
        block = play(drive, excitation.stimulus, excitation.request, motor=known.motor)
    if block is None:
        raise BenchError(f"the excitation '{excitation.name}' was not captured")
    return block


def spent_J(excitations: Sequence[Excitation], blocks: Sequence[Block], R_s_ohm: float) -> float:
    """Return heat in the winding and mechanical work of captures: 3/2 R_s |i|^2 and T omega_m over time.

    An excitation whose capture has no currents, or comes after a time of settling, counts as it was planned,
    in proportion to that time.
    """
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
            total += float(np.sum(block.column("torque") * block.column("omega_m"))) * row_s
    return total
