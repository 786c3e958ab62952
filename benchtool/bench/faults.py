"""Faults of an emulated bench, as plans, commands and tests ask for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from benchtool.bench.wires import registry
from benchtool.bench.wires.wire import FarEnd
from benchtool.errors import UsageError


class Faults(Protocol):
    """Injects faults into the bench that a drive stands on; only an emulated one can."""

    def inject(self, fault: str) -> object:
        """Arm a fault, spelled `NAME[:key=value,...][@SECONDS]`; the seconds are of drive time from now.

        Raises:
            ValueRefused: no such fault, or a value that it cannot have.
        """

    def end(self) -> None:
        """End every fault, and forget those that have not begun; what they have caused stays."""


@dataclass(frozen=True)
class FaultEntry:
    """A row of the table of faults; `parameters` with default, unit and meaning."""

    name: str
    place: str
    does: str
    outcome: str
    named: str
    can_only: bool
    parameters: tuple[tuple[str, float | str, str, str], ...]


def fault_table() -> tuple[FaultEntry, ...]:
    """Return every fault that an emulated bench can have."""
    from benchtool.emulator.faults import FAULTS

    return tuple(
        FaultEntry(
            kind.name,
            str(kind.place),
            kind.does,
            str(kind.outcome),
            kind.named,
            kind.can_only,
            tuple((each.name, each.default, each.unit, each.meaning) for each in kind.parameters),
        )
        for kind in FAULTS.values()
    )


def require_faults(faults: Sequence[str], link: str) -> None:
    """Refuse faults that cannot be, or a bench that cannot have any.

    Raises:
        ValueRefused: no such fault or value.
        UsageError: the link leads to no emulated bench of this process.
    """
    if not faults:
        return
    from benchtool.emulator.faults import parse_fault

    for each in faults:
        parse_fault(each)
    if registry.far_end(link) is not FarEnd.EMULATED_DRIVE:
        raise UsageError(
            f"the plan injects faults ({', '.join(faults)}) and the link is '{link}': faults are injected "
            f"into an emulated bench, run it with --link emulated"
        )
