"""The composition root: a profile and a link address become one session on a bench.

Only this module and `benchtool.bench.serving` know both the host's side and the emulated drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import can

from benchtool.bench.equipment import (
    Declared,
    LoadMachine,
    Supply,
    Thermometer,
    Transducer,
    declared,
)
from benchtool.bench.mounting import mount
from benchtool.clock import Clock, RealClock, VirtualClock
from benchtool.drive import RemoteDrive
from benchtool.errors import UsageError
from benchtool.link import Link
from benchtool.link.address import Address
from benchtool.link.canopen.bus import open_bus
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.canopen.stamps import AdapterStamps
from benchtool.link.port import open_port
from benchtool.link.replay import ReplayLink
from benchtool.link.serial.link import SerialLink
from benchtool.profile import Profile, altered, eds_path, load_profile, profile_path
from benchtool.protocol.dictionary import Dictionary
from benchtool.recording import Bundle
from benchtool.recording.manifest import MANIFEST

if TYPE_CHECKING:
    from benchtool.telemetry import FrameLog


@dataclass(frozen=True)
class Session:
    """One connected bench; equipment that it has not is None."""

    profile_name: str
    profile: Profile
    profile_toml: str
    drive: RemoteDrive
    clock: Clock
    load: LoadMachine | None = None
    transducer: Transducer | None = None
    supply: Supply | None = None
    thermometer: Thermometer | None = None


@contextmanager
def open_session(
    profile_name: str,
    url: str = "emulated",
    *,
    seed: int = 0,
    real_time: bool = False,
    note: Callable[[str], None] = lambda _: None,
    alter: Mapping[str, float] = MappingProxyType({}),
    frames: FrameLog | None = None,
    first_tick: int = 0,
    instruments: bool = True,
) -> Iterator[Session]:
    """A session whose drive is not yet checked; on the way out it is disabled and everything is closed.

    Args:
        profile_name: a shipped profile's name or a TOML file.
        url: link address.
        seed: of the emulated bench's noise.
        real_time: pace an emulated bench by the wall clock.
        note: takes a line where something takes its time.
        alter: what differs on an emulated bench, as `profile.altered` takes it.
        frames: takes every frame of the session.
        first_tick: the tick at which an emulated drive is powered up.
        instruments: listen to those on CAN that the profile names; a session without them has no such
            equipment, and does not hang on their adapters.

    Raises:
        ProfileError, DictionaryError, UsageError: what was asked for cannot be.
        LinkError: the adapter or the port cannot be opened.
    """
    source = profile_path(profile_name)
    profile = altered(load_profile(profile_name), alter)
    address = Address.parse(url)
    if alter and address.kind != "emulated":
        raise UsageError(
            f"the plan alters the emulated bench ({', '.join(alter)}) and the link is '{url}': "
            f"run it with --link emulated"
        )
    node_id = address.node_id(profile.drive.node_id)
    text = source.read_text(encoding="utf-8")
    eds = eds_path(profile, source)
    dictionary = Dictionary.from_eds(eds, node_id)
    what = declared(profile, address)
    if not instruments:
        what = what.without_instruments()
    if frames is not None and address.wire == "serial":
        raise UsageError(
            f"frames are those of CAN and the link is '{url}': record without --frames, or over CAN"
        )
    with ExitStack() as stack:
        if address.kind == "emulated":
            # Imported here: compiled code is of no use to a session with a real drive.
            from benchtool.emulator.bench import EmulatedBench

            if not emulator_is_compiled():
                note("compiling the emulated drive, once on this machine: a few seconds")
            # A bus that is named may have listeners, whatever the host itself goes over.
            wire: Literal["can", "serial"] = "can" if address.channel or address.wire == "can" else "serial"
            bench = EmulatedBench(
                profile, address.channel, seed=seed, paced=real_time, first_tick=first_tick, wire=wire
            )
            stack.callback(bench.close)

            def open_emulated() -> Link:
                if address.wire == "serial":
                    return SerialLink(bench.host_port(), node_id, bench.clock)
                bus: can.BusABC = bench.host_bus()
                if frames is not None:
                    bus = frames.tap(bus, bench.clock)
                return CanopenLink(bus, node_id, bench.clock, arrival_s=_timestamp)

            drive = _drive(stack, open_emulated, dictionary, eds.name, bench.clock)
            stack.callback(bench.load.apply, 0.0)
            mounted = mount(stack, what, source, drive.link, bench.clock, bench)
            yield Session(profile_name, profile, text, drive, bench.clock, **vars(mounted))
        elif address.kind == "replay":
            replayed = VirtualClock(paced=real_time)
            if (Path(address.channel) / MANIFEST).is_file():
                Bundle.open(Path(address.channel)).require_intact()
            recording = ReplayLink(Path(address.channel), node_id, replayed)
            stack.callback(recording.close)
            drive = stack.enter_context(RemoteDrive(recording, dictionary, eds.name, replayed))
            yield Session(profile_name, profile, text, drive, replayed)
        else:
            clock = RealClock()

            def open_real() -> Link:
                if address.wire == "serial":
                    return SerialLink(open_port(address.channel, address.baudrate), node_id, clock)
                bus = open_bus(address)
                if frames is not None:
                    bus = frames.tap(bus, clock, stamp=True)
                stamps = AdapterStamps(clock) if frames is None else _timestamp
                return CanopenLink(bus, node_id, clock, arrival_s=stamps)

            drive = _drive(stack, open_real, dictionary, eds.name, clock)
            mounted = mount(stack, what, source, drive.link, clock)
            yield Session(profile_name, profile, text, drive, clock, **vars(mounted))


def _drive(
    stack: ExitStack, open_link: Callable[[], Link], dictionary: Dictionary, source: str, clock: Clock
) -> RemoteDrive:
    """A drive whose link, the first or a later one, is closed after it was disabled."""
    drive = RemoteDrive(open_link(), dictionary, source, clock, reopen=open_link)
    stack.callback(drive.close_link)
    return stack.enter_context(drive)


def _timestamp(frame: can.Message) -> float:
    return frame.timestamp


def dictionary_of(profile_name: str) -> Dictionary:
    """The dictionary of the drive that a profile describes.

    Raises:
        ProfileError, DictionaryError: the profile or its EDS cannot be read.
    """
    profile = load_profile(profile_name)
    return Dictionary.from_eds(eds_path(profile, profile_path(profile_name)), profile.drive.node_id)


def equipment_of(profile_name: str, url: str) -> Declared:
    """What stands on the bench of a profile whose drive is at a link address; nothing is opened.

    Raises:
        ProfileError, UsageError: the profile or the address is wrong, or they do not fit each other.
    """
    return declared(load_profile(profile_name), Address.parse(url))


def emulator_is_compiled() -> bool:
    """Whether this machine holds the compiled emulator, or its first run will compile it."""
    from benchtool.emulator.core.kernel import kernel_is_cached

    return kernel_is_cached()
