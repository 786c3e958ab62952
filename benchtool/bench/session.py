"""The composition root: a profile and a link address become one session on a bench.

Only the wires (`benchtool.bench.wires`) and `benchtool.bench.serving` know both the host's side and the
emulated drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING

from benchtool.bench.equipment import (
    Declared,
    EnergyMeter,
    LoadMachine,
    Supply,
    Thermometer,
    Transducer,
    declared,
)
from benchtool.bench.faults import Faults
from benchtool.bench.mounting import mount
from benchtool.bench.wires import registry
from benchtool.bench.wires.address import Address
from benchtool.bench.wires.failures import naming_wires
from benchtool.bench.wires.wire import Connection, FarEnd, Opening
from benchtool.clock import Clock
from benchtool.drive import RemoteDrive, find_index
from benchtool.errors import UsageError
from benchtool.link import Link, StreamSupervisor
from benchtool.profile import Profile, altered, load_profile, profile_path
from benchtool.protocol.dictionary import Dictionary, profiled_dictionary

if TYPE_CHECKING:
    from benchtool.telemetry import FrameLog


@dataclass(frozen=True)
class Session:
    """One connected bench; missing equipment is None."""

    profile_name: str
    profile: Profile
    profile_toml: str
    drive: RemoteDrive
    clock: Clock
    load: LoadMachine | None = None
    transducer: Transducer | None = None
    supply: Supply | None = None
    thermometer: Thermometer | None = None
    energy_meter: EnergyMeter | None = None
    faults: Faults | None = None


@contextmanager
def open_session(
    profile_name: str,
    link: str | Link = "emulated",
    *,
    seed: int = 0,
    real_time: bool = False,
    note: Callable[[str], None] = lambda _: None,
    alter: Mapping[str, float] = MappingProxyType({}),
    frames: FrameLog | None = None,
    first_tick: int = 0,
    instruments: bool = True,
    enabling: bool = False,
) -> Iterator[Session]:
    """Open a session whose drive is not yet checked; on exit it is disabled and everything opened is closed.

    Args:
        profile_name: a shipped profile's name or a TOML file.
        link: address of a link; or an open one, which stays open, and whose session cannot reconnect.
        seed: of the emulated bench's noise.
        real_time: pace an emulated bench by the wall clock.
        note: called with a message where something takes time.
        alter: what differs on an emulated bench, as `profile.altered` takes it.
        frames: takes every frame of the session.
        first_tick: the tick at which an emulated drive is powered up.
        instruments: use those on CAN that the profile names; a session without them does not need their
            adapters.
        enabling: the drive is to be enabled without them; the thermometer is used where `[limits]` of the
            profile have a temperature.

    Raises:
        ProfileError, DictionaryError, UsageError: what was asked for cannot be.
        LinkError: the adapter or the port cannot be opened.
        PlugInError: the wire of another package fails; also later, out of the `with` block.
    """
    source = profile_path(profile_name)
    profile = altered(load_profile(profile_name), alter)
    text = source.read_text(encoding="utf-8")
    address = registry.parse(link) if isinstance(link, str) else link
    node_id = address.node_id(profile.drive.node_id) if isinstance(address, Address) else address.node_id
    dictionary = profiled_dictionary(profile, source, node_id)
    far_end = registry.wire_of(address).far_end if isinstance(address, Address) else FarEnd.DRIVE
    what = declared(profile, far_end)
    if not instruments:
        limited = profile.limits.temperature_degC is not None
        what = what.without_instruments(thermometer=enabling and limited)
    opening = Opening(profile, node_id, seed, real_time, first_tick, frames, note)
    with naming_wires(), ExitStack() as stack:
        if isinstance(address, Address):
            connection = _connect(stack, address, opening, alter)
        else:
            connection = _lent(address, opening, alter)
        reopen = connection.open_link if connection.reopens else None
        drive = RemoteDrive(
            connection.open_link(),
            dictionary,
            PurePath(dictionary.source).name,
            connection.clock,
            reopen=reopen,
            allow_unsupervised=profile.drive.allow_unsupervised,
            link_timeout_s=profile.drive.link_timeout_s,
            prove_watchdog=profile.drive.prove_watchdog,
        )
        if connection.reopens:
            stack.callback(drive.close_link)
        stack.enter_context(drive)
        bench = connection.bench
        if bench is not None:
            stack.callback(bench.load.apply, 0.0)
        mounted = mount(stack, what, source, drive.link, connection.clock, bench)
        faults = None if bench is None else bench.faults
        if (current_A := profile.drive.index_search_A) is not None:
            drive.index_search = partial(find_index, drive, profile.motor, current_A)
        drive.supervisor = _supervisor(drive, profile, mounted.thermometer, note)
        yield Session(profile_name, profile, text, drive, connection.clock, **vars(mounted), faults=faults)


def _supervisor(
    drive: RemoteDrive, profile: Profile, thermometer: Thermometer | None, note: Callable[[str], None]
) -> StreamSupervisor | None:
    """Return what supervises the limits of a profile; None of one that states none."""
    if not profile.limits.model_fields_set:
        return None
    from benchtool.telemetry import LimitSupervision

    def winding_degC() -> float | None:
        return None if thermometer is None else thermometer.temperatures().winding_degC

    return LimitSupervision(drive, profile.limits, winding_degC, note)


def _connect(stack: ExitStack, address: Address, opening: Opening, alter: Mapping[str, float]) -> Connection:
    """Return the way to the drive at an address."""
    wire = registry.wire_of(address)
    if wire.far_end is not FarEnd.EMULATED_DRIVE:
        _require_unaltered(alter, f"'{address.url}'")
    if opening.frames is not None and not registry.carrier(address).carries_frames:
        raise UsageError(
            f"frames are those of CAN and the link is '{address.url}': record without --frames, or over CAN"
        )
    assert wire.connect is not None  # it has addresses
    return wire.connect(stack, address, opening)


def _lent(link: Link, opening: Opening, alter: Mapping[str, float]) -> Connection:
    """Return the way to a drive whose link is open already."""
    _require_unaltered(alter, "an open link")
    if opening.frames is not None:
        raise UsageError("frames are kept from the opening of a link on: give its address instead")
    return Connection(link.clock, lambda: link, reopens=False)


def _require_unaltered(alter: Mapping[str, float], link: str) -> None:
    if alter:
        raise UsageError(
            f"the plan alters the emulated bench ({', '.join(alter)}) and the link is {link}: "
            f"run it with --link emulated"
        )


def dictionary_of(profile_name: str) -> Dictionary:
    """Return the dictionary of the drive that a profile describes.

    Raises:
        ProfileError, DictionaryError: the profile or its EDS cannot be read.
    """
    profile = load_profile(profile_name)
    return profiled_dictionary(profile, profile_path(profile_name), profile.drive.node_id)


def equipment_of(profile_name: str, url: str) -> Declared:
    """Return what stands on the bench of a profile whose drive is at a link address; nothing is opened.

    Raises:
        ProfileError, UsageError: the profile or the address is wrong, or they do not fit each other.
    """
    return declared(load_profile(profile_name), registry.far_end(url))


def emulator_is_compiled(profile_name: str) -> bool:
    """Return whether this machine holds the emulator compiled for a profile's bench, or its first run
    compiles it.

    Raises:
        ProfileError: the profile cannot be read, or describes no emulated bench.
    """
    from benchtool.emulator import is_compiled

    return is_compiled(load_profile(profile_name))
