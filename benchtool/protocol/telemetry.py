"""The slow stream: records of signals of one tick, divided over TPDOs and reassembled.

A record is a row of words of four bytes, two to a PDO:

    tick, stream_sequence | channel 1, channel 2 | ... | channel n, stream_sequence

The PDOs of a record follow each other on the wire in the order of their COB-IDs. A record counts if each of
them came, in that order, and the sequence number in the last one is that of the first: since frames arrive in
the order of sending, records cannot be mixed. An incomplete record is a gap.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from benchtool.block import Block, Channel, Gap
from benchtool.errors import ValueRefused, of_each
from benchtool.protocol.canopen.pdo import Pdo, event_timer_ticks, most_tpdos, tpdo, tpdo_numbers
from benchtool.protocol.dictionary.dictionary import Dictionary
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Variable
from benchtool.ticks import TICKS, ticks_since, unwrap_tick

COUNTING_SIGNALS = {
    "adc_saturated": "current samples at either end of the converter's range",
    "law_clipped": "ticks in which the law could not reach its reference and clipped",
}
"""Signals that are counters of the drive, with descriptions."""

_WORD = 4
_WORDS_PER_PDO = 2
_FRAMING_WORDS = 3  # tick, and the sequence number twice
_STAMP = struct.Struct("<LL")
_SEQUENCE = struct.Struct("<L")


@dataclass(frozen=True)
class StreamLayout:
    """Layout of a record: its signals and PDOs, and the rate: what the event timers are set to, and the
    nearest whole number of ticks, which the drive makes of it."""

    channels: tuple[Variable, ...]
    pdos: tuple[Pdo, ...]
    timer_ms: int
    stride: int
    tick_s: float

    @property
    def period_s(self) -> float:
        """Drive time between two records."""
        return self.stride * self.tick_s

    @cached_property
    def block_channels(self) -> tuple[Channel, ...]:
        return tuple(Channel(each.name, each.unit) for each in self.channels)


def stream_layout(
    dictionary: Dictionary, node_id: int, names: Sequence[str], rate_Hz: float, tick_s: float
) -> StreamLayout:
    """Return the layout of a stream of these signals.

    Args:
        rate_Hz: records per second; the drive's event timers count whole milliseconds.
        tick_s: the drive's control period.

    Raises:
        ValueRefused: the drive has no stream, or cannot stream this.
    """
    for name in ("tick", "stream_sequence"):
        if name not in dictionary:
            raise ValueRefused(
                f"{dictionary.source} has no object '{name}', which a record of the slow stream needs: "
                f"record with a drive of benchtool's dictionary"
            )
    channels = tuple(of_each(partial(stream_channel, dictionary), names))
    tick, sequence = dictionary["tick"], dictionary["stream_sequence"]
    words = [each.mapping for each in (tick, sequence, *channels, sequence)]
    pairs = [words[start : start + _WORDS_PER_PDO] for start in range(0, len(words), _WORDS_PER_PDO)]
    try:
        numbers = tpdo_numbers(node_id, len(pairs))
    except ValueError as reason:
        raise ValueRefused(
            f"{len(channels)} channels need {reason}: choose fewer channels; eight TPDOs hold 13, four hold 5"
        ) from None
    if not channels or len(set(names)) != len(names):
        raise ValueRefused(
            f"channels are '{','.join(names)}', one or more different signals are expected: name each once"
        )
    pdos = (tpdo(node_id, pair, number) for number, pair in zip(numbers, pairs, strict=True))
    timer_ms = _event_timer_ms(rate_Hz)
    stride = max(1, event_timer_ticks(timer_ms, tick_s))
    return StreamLayout(channels, tuple(pdos), timer_ms, stride, tick_s)


def most_channels(node_id: int) -> int:
    """Return how many channels a record of this node can hold: 13, or 5 of node ids from 64."""
    return most_tpdos(node_id) * _WORDS_PER_PDO - _FRAMING_WORDS


def _event_timer_ms(rate_Hz: float) -> int:
    if not 0.0 < rate_Hz < 1e6:
        raise ValueRefused(f"a rate of {rate_Hz:g} Hz is not possible: choose 0.0153 to 1000 Hz")
    ms = 1e3 / rate_Hz
    whole = max(1, min(0xFFFF, round(ms)))
    if abs(ms - whole) > 1e-4 * ms:
        raise ValueRefused(
            f"a rate of {rate_Hz:g} Hz is a record every {ms:g} ms, the drive counts whole ms, 1 to 65535: "
            f"choose {1e3 / whole:.6g} Hz"
        )
    return whole


def stream_channel(dictionary: Dictionary, name: str) -> Variable:
    """Return the signal of this name, which a stream can carry.

    Raises:
        ValueRefused: there is none, or it is not one of four bytes that can be mapped.
    """
    variable = dictionary[name]
    if not variable.mappable or variable.type not in (DataType.F32, DataType.U32, DataType.I32):
        raise ValueRefused(
            f"'{name}' ({variable.type}, {variable.role}) cannot be a channel of the stream, a signal of "
            f"four bytes is expected: choose one of those marked P in the drive's dictionary"
        )
    return variable


@dataclass(frozen=True)
class StreamCounters:
    """Counters of the records of a stream."""

    received: int = 0
    missing: int = 0  # by the ticks between those received
    lost: int = 0  # by the sequence numbers between those received: sent, but not received whole
    incomplete: int = 0  # begun, not ended
    off_grid: int = 0  # whole, but their ticks continue no row of this stream
    malformed: int = 0  # PDOs of a wrong length


class RecordDecoder:
    """Assembles records from PDOs, and Blocks from records. Never raises on received data.

    Args:
        layout: of a record.
        near: a tick of the drive at about this time, counted on, which the ticks of the records follow.
    """

    def __init__(self, layout: StreamLayout, near: int | None = None) -> None:
        self.layout = layout
        self.arrival_s = 0.0
        """Arrival of the first PDO of the last record received."""
        self.tick = 0
        """Its tick, counted on past 2**32."""
        self._places = {pdo.can_id: place for place, pdo in enumerate(layout.pdos)}
        self._lengths = [_WORD * len(pdo.mappings) for pdo in layout.pdos]
        self._parts = [b""] * len(layout.pdos)
        self._near = near
        self._next = 0
        self._begun_s = 0.0
        self._sequence = 0
        self._rows: list[bytes] = []
        self._row_ticks: list[int] = []
        self._received = self._missing = self._lost = 0
        self._incomplete = self._off_grid = self._malformed = 0

    @property
    def counters(self) -> StreamCounters:
        """Snapshot."""
        return StreamCounters(
            self._received, self._missing, self._lost, self._incomplete, self._off_grid, self._malformed
        )

    @property
    def rows(self) -> int:
        """Rows that wait to be taken."""
        return len(self._rows)

    def feed(self, can_id: int, data: bytes, arrival_s: float) -> bool:
        """Add a frame; return whether it completed a record."""
        place = self._places.get(can_id)
        if place is None:
            return False
        if len(data) != self._lengths[place]:
            self._malformed += 1
            self._give_up()
            return False
        if place != self._next:
            self._give_up()
            if place:
                return False
        if place == 0:
            self._begun_s = arrival_s
        self._parts[place] = data
        self._next = place + 1
        if self._next < len(self._parts):
            return False
        return self._complete(b"".join(self._parts))

    def pop_block(self) -> Block | None:
        """Return the rows since the last call and clear them; None if there are none."""
        if not self._rows:
            return None
        words = np.frombuffer(b"".join(self._rows), dtype="<u4").reshape(len(self._rows), -1)
        columns = np.ascontiguousarray(words[:, 2:-1].T)
        data = np.empty((len(words), len(columns)))
        for number, (column, channel) in enumerate(zip(columns, self.layout.channels, strict=True)):
            assert channel.type.numpy is not None
            data[:, number] = column.view(channel.type.numpy)
            if channel.factor != 1:
                data[:, number] *= channel.factor
        ticks = self._row_ticks
        stride = self.layout.stride
        gaps = tuple(
            Gap(row, (tick - before) // stride - 1)
            for row, (before, tick) in enumerate(pairwise(ticks), start=1)
            if tick - before != stride
        )
        self._rows, self._row_ticks = [], []
        return Block(self.layout.block_channels, ticks[0], stride, self.layout.tick_s, data, gaps)

    def _give_up(self) -> None:
        if self._next:
            self._incomplete += 1
            self._next = 0

    def _complete(self, record: bytes) -> bool:
        tick, sequence = _STAMP.unpack_from(record)
        (confirmed,) = _SEQUENCE.unpack_from(record, len(record) - _WORD)
        if confirmed != sequence:
            self._give_up()
            return False
        self._next = 0
        if self._received:
            ticks = ticks_since(tick, self.tick)
            steps, rest = divmod(ticks, self.layout.stride)
            if rest or not 0 < ticks < TICKS // 2:
                self._off_grid += 1
                return False
            self._missing += steps - 1
            self._lost += max(0, ticks_since(sequence, self._sequence) - 1)
            self.tick += ticks
        else:
            self.tick = unwrap_tick(tick, self._near)
        self._sequence = sequence
        self._received += 1
        self.arrival_s = self._begun_s
        self._rows.append(record)
        self._row_ticks.append(self.tick)
        return True
