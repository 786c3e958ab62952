"""The composition root: a profile and a link address become one session on a bench.

Only the wires (`benchtool.bench.wires`) and `benchtool.bench.serving` know both the host's side and the
emulated drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

from benchtool.bench.wires import registry
from benchtool.bench.wires.address import Address
from benchtool.bench.wires.wire import Connection, FarEnd, Opening
from benchtool.block import Block
from benchtool.clock import Clock
from benchtool.drive import RemoteDrive
from benchtool.errors import UsageError
from benchtool.link import Link
from benchtool.profile import Profile, altered, load_profile, profile_path
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.profiled import profiled_dictionary

if TYPE_CHECKING:
    from benchtool.telemetry import FrameLog


class LoadMachine(Protocol):
    """Equipment on the shaft that loads the motor."""

    def apply(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed. It may turn as it likes again."""

    def hold(self, omega_m_rad_s: float) -> None:
        """Turn the shaft at this speed, whatever torque that takes."""


class Transducer(Protocol):
    """A torque transducer on the shaft, with a sampling of its own."""

    @property
    def longest_s(self) -> float:
        """The longest time that it records."""

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""

    def block(self) -> Block:
        """What was recorded, as channel `torque_transducer`."""


@dataclass(frozen=True)
class Session:
    """One connected bench; `load` and `transducer` are None where the bench has none."""

    profile_name: str
    profile: Profile
    profile_toml: str
    drive: RemoteDrive
    clock: Clock
    load: LoadMachine | None = None
    transducer: Transducer | None = None


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
) -> Iterator[Session]:
    """A session whose drive is not yet checked; on the way out it is disabled and what was opened is closed.

    Args:
        profile_name: a shipped profile's name or a TOML file.
        link: address of a link; or an open one, which stays open, and whose session cannot reconnect.
        seed: of the emulated bench's noise.
        real_time: pace an emulated bench by the wall clock.
        note: takes a line where something takes its time.
        alter: what differs on an emulated bench, as `profile.altered` takes it.
        frames: takes every frame of the session.
        first_tick: the tick at which an emulated drive is powered up.

    Raises:
        ProfileError, DictionaryError, UsageError: what was asked for cannot be.
        LinkError: the adapter or the port cannot be opened.
    """
    source = profile_path(profile_name)
    profile = altered(load_profile(profile_name), alter)
    text = source.read_text(encoding="utf-8")
    address = registry.parse(link) if isinstance(link, str) else link
    node_id = address.node_id(profile.drive.node_id) if isinstance(address, Address) else address.node_id
    dictionary = profiled_dictionary(profile, source, node_id)
    opening = Opening(profile, node_id, seed, real_time, first_tick, frames, note)
    with ExitStack() as stack:
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
        )
        if connection.reopens:
            stack.callback(drive.close_link)
        stack.enter_context(drive)
        bench = connection.bench
        if bench is None:
            yield Session(profile_name, profile, text, drive, connection.clock)
        else:
            stack.callback(bench.load.apply, 0.0)
            yield Session(profile_name, profile, text, drive, bench.clock, bench.load, bench.transducer)


def _connect(stack: ExitStack, address: Address, opening: Opening, alter: Mapping[str, float]) -> Connection:
    """The way to the drive at an address."""
    wire = registry.wire_of(address)
    if wire.far_end is not FarEnd.EMULATED_DRIVE:
        _require_unaltered(alter, f"'{address.url}'")
    if opening.frames is not None and not registry.carrier(address).carries_frames:
        raise UsageError(
            f"frames are those of CAN and the link is '{address.url}': record without --frames, or over CAN"
        )
    assert wire.connect is not None  # it has a form
    return wire.connect(stack, address, opening)


def _lent(link: Link, opening: Opening, alter: Mapping[str, float]) -> Connection:
    """The way to a drive whose link is open already."""
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
    """The dictionary of the drive that a profile describes.

    Raises:
        ProfileError, DictionaryError: the profile or its EDS cannot be read.
    """
    profile = load_profile(profile_name)
    return profiled_dictionary(profile, profile_path(profile_name), profile.drive.node_id)


def has_transducer(url: str) -> bool:
    """Whether the bench at a link address has a torque transducer: an emulated one in this process.

    Raises:
        UsageError: the address is none.
    """
    return registry.far_end(url) is FarEnd.EMULATED_DRIVE


def emulator_is_compiled() -> bool:
    """Whether this machine holds the compiled emulator, or its first run will compile it."""
    from benchtool.emulator.core.kernel import kernel_is_cached

    return kernel_is_cached()
