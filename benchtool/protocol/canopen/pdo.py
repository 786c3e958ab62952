"""Process data objects (CiA 301, 7.2.2): their identifiers, and the order in which they are set up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from benchtool.protocol.canopen import cob_id
from benchtool.protocol.canopen.cob_id import INVALID

RPDO_COMMUNICATION, RPDO_MAPPING = 0x1400, 0x1600
TPDO_COMMUNICATION, TPDO_MAPPING = 0x1800, 0x1A00
"""Indices of the parameters of the first PDO of each kind (7.5.2.35 to 38)."""

RPDOS = range(RPDO_COMMUNICATION, RPDO_MAPPING)
TPDOS = range(TPDO_COMMUNICATION, TPDO_MAPPING)
PDO_PARAMETERS = range(RPDO_COMMUNICATION, TPDO_MAPPING + len(TPDOS))
"""Indices of the communication parameters of all PDOs of a kind, and of every parameter of them."""

BY_TIMER = 255
"""Transmission type: event-driven, specific to the device profile; here by the event timer."""

MAX_ENTRIES = 4
MAX_BITS = 64


@dataclass(frozen=True)
class Pdo:
    """Parameters of one PDO, `number` from 1; `mappings` as `Variable.mapping` has them, in their order."""

    number: int
    can_id: int
    mappings: tuple[int, ...]
    transmit: bool

    @property
    def communication(self) -> int:
        """Index of the communication parameter."""
        return (TPDO_COMMUNICATION if self.transmit else RPDO_COMMUNICATION) + self.number - 1

    @property
    def mapping(self) -> int:
        """Index of the mapping parameter."""
        return (TPDO_MAPPING if self.transmit else RPDO_MAPPING) + self.number - 1

    @property
    def switch_off(self) -> tuple[str, int]:
        """The write that disables it."""
        return f"0x{self.communication:04X}:1", INVALID | self.can_id

    def set_up(self, period_s: float = 0.0) -> Iterator[tuple[str, int | float]]:
        """Yield the writes that enable it, in their order (7.5.2.36 to 38): label and value of each.

        Args:
            period_s: of the event timer of a TPDO.
        """
        yield self.switch_off
        yield f"0x{self.communication:04X}:2", BY_TIMER
        if self.transmit:
            yield f"0x{self.communication:04X}:5", period_s
        yield f"0x{self.mapping:04X}:0", 0
        for position, mapping in enumerate(self.mappings, start=1):
            yield f"0x{self.mapping:04X}:{position}", mapping
        yield f"0x{self.mapping:04X}:0", len(self.mappings)
        yield f"0x{self.communication:04X}:1", self.can_id


def event_timer_ticks(timer_ms: int, tick_s: float) -> int:
    """Return the ticks between two transmissions by an event timer: the nearest whole number, a half up.

    A drive calculates it from whole nanoseconds, and so does this, or both would differ where a millisecond
    is an odd number of half ticks: 12.5 of 80 us.
    """
    tick_ns = round(tick_s * 1e9)
    return (timer_ms * 1_000_000 + tick_ns // 2) // tick_ns


def rpdo(node_id: int, mappings: Sequence[int], number: int = 1) -> Pdo:
    """Return the drive's receive PDO with its predefined identifier."""
    return Pdo(number, cob_id.RPDO[number - 1] + node_id, tuple(mappings), transmit=False)


def most_tpdos(node_id: int) -> int:
    """Return how many TPDOs a node has whose COB-IDs do not belong to another node."""
    return len(cob_id.TPDO) if node_id <= cob_id.LAST_NODE_OF_EIGHT_TPDOS else 4


def tpdo_numbers(node_id: int, count: int) -> list[int]:
    """Return the numbers of the first `count` TPDOs in their order on the wire, that of their COB-IDs.

    Raises:
        ValueError: there are fewer, or their COB-IDs would belong to another node.
    """
    most = most_tpdos(node_id)
    if count > most:
        raise ValueError(f"{count} TPDOs of node {node_id}, which has {most}")
    return sorted(range(1, count + 1), key=lambda number: cob_id.TPDO[number - 1])


def tpdo(node_id: int, mappings: Sequence[int], number: int) -> Pdo:
    """Return the drive's transmit PDO with the identifier of `cob_id.TPDO`."""
    return Pdo(number, cob_id.TPDO[number - 1] + node_id, tuple(mappings), transmit=True)
