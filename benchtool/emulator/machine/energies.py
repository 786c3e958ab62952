"""Energy accounts as the bench tells them: their names, and a recorder of them, a row per drive tick.

    supply = link_resistance + chopper + capacitor + dc
    dc = copper + iron + inverter + friction + shaft + magnetic + kinetic
    shaft = coupling + twist + load_kinetic + load

Since power-up, in J. What `capacitor`, `magnetic`, `kinetic`, `twist` and `load_kinetic` name is stored,
`load` is what the load machine and the driven machine take; the others are passed on or lost where their name
says.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block, Channel
from benchtool.emulator.jit import njit
from benchtool.errors import ValueRefused

NAMES: Final = (
    "supply", "link_resistance", "chopper", "capacitor", "dc", "copper", "iron", "inverter", "friction",
    "shaft", "magnetic", "kinetic", "coupling", "twist", "load_kinetic", "load",
)  # fmt: skip
FIELDS: Final = tuple((f"E_{name}", "f8") for name in NAMES)
MAX_TICKS: Final = 2_000_000


class Accounts(NamedTuple):
    """What energy accounts need of the devices: their resistance, a part of the machine's, and their drop."""

    R_devices: float
    drop: float


@njit
def keep_energies(accounts: Accounts | None, record: Any, rows: NDArray[np.float64]) -> None:
    """Write the accounts of this tick into the row that is next, while they are recorded."""
    if accounts is None:
        return
    if record.rows < rows.shape[0]:
        write_energies(record, rows[record.rows])
        record.rows += 1


@njit
def write_energies(record: Any, row: NDArray[np.float64]) -> None:
    """Write the accounts into a row, in the order of `NAMES`."""
    row[0], row[1], row[2], row[3] = (
        record.E_supply,
        record.E_link_resistance,
        record.E_chopper,
        record.E_capacitor,
    )
    row[4], row[5], row[6], row[7] = record.E_dc, record.E_copper, record.E_iron, record.E_inverter
    row[8], row[9], row[10], row[11] = (
        record.E_friction,
        record.E_shaft,
        record.E_magnetic,
        record.E_kinetic,
    )
    row[12], row[13], row[14], row[15] = (
        record.E_coupling,
        record.E_twist,
        record.E_load_kinetic,
        record.E_load,
    )


class EnergyRecorder:
    """Records the accounts, a row per drive tick; the kernel fills its buffer while the core runs.

    Args:
        record: of the accounts.
        tick: tells the drive's tick, counted on past 2**32.
        control_period_s: length of a drive tick.
    """

    def __init__(self, record: Any, tick: Callable[[], int], control_period_s: float) -> None:
        self._record = record
        self._tick = tick
        self._period_s = control_period_s
        self._first_tick = 0
        self.rows = np.zeros((0, len(NAMES)))

    def now_J(self) -> dict[str, float]:
        """Return the accounts since power-up by their names; zeros where none are kept."""
        return {name: float(self._record[f"E_{name}"]) for name in NAMES}

    def start(self, ticks: int) -> None:
        """Discard earlier rows and record those of this tick and the next `ticks`.

        Raises:
            ValueRefused: `ticks` is not between 1 and 2 000 000.
        """
        if not 1 <= ticks <= MAX_TICKS:
            raise ValueRefused(f"energies: {ticks} ticks asked, 1 to {MAX_TICKS} can be: record in parts")
        self.rows = np.zeros((ticks + 1, len(NAMES)))
        self._first_tick = self._tick()
        write_energies(self._record, self.rows[0])
        self._record.rows = 1

    def block(self) -> Block:
        """Return what was recorded since `start`: channels `energy_supply` to `energy_load` in J."""
        return Block(
            channels=tuple(Channel(f"energy_{name}", "J") for name in NAMES),
            first_tick=self._first_tick,
            stride=1,
            tick_s=self._period_s,
            data=self.rows[: int(self._record.rows)].copy(),
        )
