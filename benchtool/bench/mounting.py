"""Connect the equipment that a profile declares: real instruments, or emulated ones behind frames."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from benchtool.bench.can_frames import BusListener, MessageListener
from benchtool.bench.dbc import DbcSupply, DbcThermometer, DbcTransducer, factor_of
from benchtool.bench.equipment import (
    Declared,
    EmulatedTemperatures,
    EnergyMeter,
    LoadMachine,
    Supply,
    Thermometer,
    Transducer,
)
from benchtool.bench.wires import registry
from benchtool.bench.wires.canopen import bus_at
from benchtool.clock import Clock
from benchtool.errors import ProfileError
from benchtool.link import Frame, FrameLink, FrameReceiver, Link
from benchtool.link.canopen import AdapterTimestamps, timestamp
from benchtool.profile import (
    DRIVES_BUS,
    Absent,
    CanFrames,
    CanSupply,
    CanTemperature,
    CanTransducer,
    Emulated,
    EmulatedTemperature,
)
from benchtool.protocol import DbcMessage
from benchtool.protocol.canopen import cob_id

if TYPE_CHECKING:
    from benchtool.emulator import EmulatedBench, EmulatedThermometer

_OF_ALL_NODES = (0x000, 0x080, 0x100)  # NMT, SYNC, TIME
_OF_A_NODE = (
    *(cob_id.EMCY, *cob_id.TPDO, *cob_id.RPDO, 0x400, 0x500),
    *(cob_id.SDO_RESPONSE, cob_id.SDO_REQUEST, cob_id.HEARTBEAT),
)
_HOST_HEARTBEAT = cob_id.HEARTBEAT + cob_id.HOST_NODE


@dataclass(frozen=True)
class Equipment:
    """Equipment of a bench, ready for use; None for what is missing."""

    load: LoadMachine | None = None
    transducer: Transducer | None = None
    supply: Supply | None = None
    thermometer: Thermometer | None = None
    energy_meter: EnergyMeter | None = None


def mount(
    stack: ExitStack,
    what: Declared,
    source: Path,
    link: Link,
    clock: Clock,
    emulated: EmulatedBench | None = None,
) -> Equipment:
    """Return the equipment of a bench whose drive is connected; `stack` closes it.

    Args:
        what: as `declared` has it.
        source: the profile's file, beside which its DBC files are.
        link: to the drive; an instrument on the drive's bus is heard through it.
        clock: the host's.
        emulated: the emulated bench, if that is what the drive stands on.

    Raises:
        ProfileError: a DBC file or what the profile says of it is wrong, or the drive has no CAN bus.
        LinkError: the bus of an instrument cannot be opened.
    """
    mounting = _Mounting(stack, source, link, clock, emulated)
    load = emulated.load if emulated is not None and isinstance(what.load, Emulated) else None
    with _stated(source, "transducer"):
        transducer = mounting.transducer(what.transducer)
    with _stated(source, "supply"):
        supply = mounting.supply(what.supply)
    with _stated(source, "temperature"):
        thermometer = mounting.thermometer(what.temperature)
    meter = None if emulated is None else emulated.energy_meter
    return Equipment(load, transducer, supply, thermometer, meter)


@contextmanager
def _stated(source: Path, table: str) -> Iterator[None]:
    """Have an error of what `[bench.TABLE]` states name the profile and the line of that table."""
    try:
        yield
    except ProfileError as wrong:
        line = _line(source, table)
        place = source if line is None else f"{source}, line {line}"
        raise ProfileError(f"{place}: [bench.{table}]: {wrong}") from None


def _line(source: Path, table: str) -> int | None:
    """Return where a profile's file has `[bench.TABLE]`, or TABLE as a key of `[bench]`, counted from 1."""
    wanted = re.compile(rf"\s*(\[\s*bench\s*\.\s*{table}\s*\]|(bench\s*\.\s*)?{table}(\s*\.\s*\w+)?\s*=)")
    try:
        lines = source.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return None
    return next((number for number, line in enumerate(lines, 1) if wanted.match(line)), None)


class _Mounting:
    """Puts one piece of equipment after the other on a bench; arguments as of `mount`."""

    def __init__(
        self, stack: ExitStack, source: Path, link: Link, clock: Clock, emulated: EmulatedBench | None
    ) -> None:
        self._stack = stack
        self._source = source
        self._link = link
        self._clock = clock
        self._emulated = emulated
        self._others: dict[str, BusListener] = {}
        self._takers: dict[tuple[str, int, bool], tuple[str, list[FrameReceiver]]] = {}

    def transducer(self, stated: Emulated | CanTransducer | Absent) -> Transducer | None:
        if isinstance(stated, CanTransducer):
            message = self._message(stated)
            transducer = DbcTransducer(stated, message, partial(self._listen, stated))
            if self._emulated is not None:
                factor = factor_of(message.ranges[stated.signals[0]], "Nm")
                self._emulated.add_torque(stated, message, factor, self._channel(stated))
            return transducer
        return (
            self._emulated.transducer if self._emulated is not None and isinstance(stated, Emulated) else None
        )

    def supply(self, stated: Emulated | CanSupply | Absent) -> Supply | None:
        if isinstance(stated, CanSupply):
            message = self._message(stated)
            supply = DbcSupply(stated, message, partial(self._listen, stated))
            if self._emulated is not None:
                if stated.i_dc:
                    raise ProfileError(
                        f"bench.supply reads '{stated.i_dc}', and the emulated bench does not know the "
                        f"current of its dc link: leave i_dc out there"
                    )
                factor, source = factor_of(message.ranges[stated.u_dc], "V"), self._emulated.supply
                self._emulated.add_readings(
                    message,
                    stated.rate_Hz,
                    lambda: {stated.u_dc: source.u_dc_V / factor},
                    self._channel(stated),
                )
            return supply
        return self._emulated.supply if self._emulated is not None and isinstance(stated, Emulated) else None

    def thermometer(self, stated: EmulatedTemperature | CanTemperature | Absent) -> Thermometer | None:
        if isinstance(stated, CanTemperature):
            message = self._message(stated)
            thermometer = DbcThermometer(stated, message, partial(self._listen, stated))
            if self._emulated is not None:
                source = self._emulated.add_thermometer(EmulatedTemperature())
                self._emulated.add_readings(
                    message, stated.rate_Hz, partial(_told, stated, source), self._channel(stated)
                )
            return thermometer
        if self._emulated is None or not isinstance(stated, EmulatedTemperature):
            return None
        return EmulatedTemperatures(self._emulated.add_thermometer(stated))

    # ---- messages and buses ------------------------------------------------------------------------------

    def _message(self, stated: CanFrames) -> DbcMessage:
        message = DbcMessage(self._source.parent / stated.dbc, stated.message, stated.read_signals)
        if stated.bus == DRIVES_BUS:
            self._require_free(message)
        return message

    def _require_free(self, message: DbcMessage) -> None:
        """Refuse an identifier that is the drive's or the host's own, which would be taken from the link."""
        node_id = self._link.node_id
        own = {*_OF_ALL_NODES, *(base + node_id for base in _OF_A_NODE), _HOST_HEARTBEAT}
        if message.extended or message.can_id in own:
            why = (
                "29-bit identifiers are not heard there"
                if message.extended
                else f"that is one of node {node_id}, of the host or of network management (CiA 301, 7.3.3)"
            )
            raise ProfileError(
                f"message '{message.name}' has identifier 0x{message.can_id:X} on the drive's bus, and "
                f"{why}: give the instrument another one, or a bus of its own"
            )

    def _listen(self, stated: CanFrames, message: DbcMessage, rate_Hz: float) -> MessageListener:
        other = None if stated.bus == DRIVES_BUS else self._other(stated.bus)
        check = (lambda: None) if other is None else other.check
        listener = MessageListener(message, rate_Hz, self._clock, check=check)
        key = (stated.bus, message.can_id, message.extended)
        name, takers = self._takers.setdefault(key, (message.name, []))
        takers.append(listener.on_frame)
        if name != message.name:
            raise ProfileError(
                f"messages '{name}' and '{message.name}' have the same identifier 0x{message.can_id:X} on "
                f"one bus: an identifier is one message's, correct the DBC file or name the bus of each"
            )
        if len(takers) > 1:
            if self._emulated is not None:
                raise ProfileError(
                    f"message '{message.name}' is read by two tables of [bench], and an emulated instrument "
                    f"sends what one of them reads: name two messages, or leave one table out there"
                )
            return listener

        def take(frame: Frame) -> None:
            for each in takers:
                each(frame)

        if other is not None:
            other.listen(message.can_id, take, extended=message.extended)
        else:
            self._subscribe(message, take)
        return listener

    def _subscribe(self, message: DbcMessage, take: FrameReceiver) -> None:
        """Hear a message through the drive's link."""
        link = self._link
        if not isinstance(link, FrameLink):
            raise ProfileError(
                f"message '{message.name}' is on the drive's bus by the profile, and the drive is on no CAN "
                f"bus: name the instrument's own bus, as bus = 'can:INTERFACE:CHANNEL?bitrate=500000'"
            )
        link.subscribe((message.can_id,), take)
        self._stack.callback(link.unsubscribe, (message.can_id,))

    def _other(self, url: str) -> BusListener:
        """Return the bus at an address, which several instruments may share."""
        if url not in self._others:
            if self._emulated is not None:
                bus = self._emulated.host_bus(f"{self._emulated.channel}/{url}")
                listener = BusListener(bus, timestamp)
            else:
                listener = BusListener(bus_at(registry.parse(url)), AdapterTimestamps(self._clock))
            self._stack.callback(listener.close)
            self._others[url] = listener
        return self._others[url]

    def _channel(self, stated: CanFrames) -> str:
        """Return the virtual channel of an instrument of the emulated bench; empty for the drive's own."""
        assert self._emulated is not None
        return "" if stated.bus == DRIVES_BUS else f"{self._emulated.channel}/{stated.bus}"


def _told(stated: CanTemperature, source: EmulatedThermometer) -> dict[str, float]:
    """Return the readings of the signals that an instrument tells."""
    readings = dict(zip((stated.winding, stated.ambient), source.read(), strict=True))
    return {name: readings[name] for name in stated.read_signals}
