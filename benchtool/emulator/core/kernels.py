"""Which kernel a bench runs: the one compiled for the parts that it has.

The kernel itself, with all that it calls, is imported when it is to be compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple

from benchtool.emulator.jit import parts_of, specialised
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.inverter import PowerStage
from benchtool.emulator.machine.sensors import Sensing
from benchtool.emulator.machine_code import is_cached

_SOURCE: Final = Path(__file__).with_name("kernel.py")


class Truth(NamedTuple):
    """What the kernel knows of the bench beside its state."""

    machine: Machine
    stage: PowerStage
    sensing: Sensing


def kernel_of(truth: Truth) -> Callable[..., int]:
    """Return `run_ticks` compiled for the parts that this bench has."""
    return specialised(_plain, _SOURCE, frozenset(parts_of(truth)))


def kernel_is_cached(truth: Truth) -> bool:
    """Return whether the first run will load the kernel within a second; else it compiles for some
    seconds."""
    return is_cached(kernel_of(truth))


def _plain() -> Callable[..., Any]:
    from benchtool.emulator.core.kernel import run_ticks

    return run_ticks
