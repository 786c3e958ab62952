"""The composition root: a profile and a link address become one session on a bench.

This is the only module that knows both the host's side and the emulated drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import can

from benchtool.block import Block
from benchtool.clock import Clock, RealClock
from benchtool.drive import RemoteDrive
from benchtool.errors import LinkError
from benchtool.link.address import Address
from benchtool.link.canopen import CanopenLink
from benchtool.profile import Profile, eds_path, load_profile, profile_path
from benchtool.protocol.dictionary import Dictionary


class LoadMachine(Protocol):
    """Equipment on the shaft that loads the motor."""

    def apply(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed."""


class Transducer(Protocol):
    """A torque transducer on the shaft, with a sampling of its own."""

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
    url: str = "emulated",
    *,
    seed: int = 0,
    real_time: bool = False,
    note: Callable[[str], None] = lambda _: None,
) -> Iterator[Session]:
    """A session whose drive is not yet checked; on the way out it is disabled and everything is closed.

    Args:
        profile_name: a shipped profile's name or a TOML file.
        url: link address.
        seed: of the emulated bench's noise.
        real_time: pace an emulated bench by the wall clock.
        note: takes a line where something takes its time.

    Raises:
        ProfileError, DictionaryError, UsageError: what was asked for cannot be.
        LinkError: the adapter cannot be opened.
    """
    source = profile_path(profile_name)
    profile = load_profile(profile_name)
    address = Address.parse(url)
    node_id = address.node_id(profile.drive.node_id)
    text = source.read_text(encoding="utf-8")
    eds = eds_path(profile, source)
    dictionary = Dictionary.from_eds(eds, node_id)
    with ExitStack() as stack:
        if address.kind == "emulated":
            # Imported here: compiled code is of no use to a session with a real drive.
            from benchtool.emulator.bench import EmulatedBench

            if not emulator_is_compiled():
                note("compiling the emulated drive, once on this machine: a few seconds")
            bench = EmulatedBench(profile, address.channel, seed=seed, paced=real_time)
            stack.callback(bench.close)
            link = CanopenLink(bench.host_bus(), node_id, bench.clock)
            stack.callback(link.close)
            drive = stack.enter_context(RemoteDrive(link, dictionary, eds.name, bench.clock))
            stack.callback(bench.load.apply, 0.0)
            yield Session(profile_name, profile, text, drive, bench.clock, bench.load, bench.transducer)
        else:
            clock = RealClock()
            link = CanopenLink(_open_can(address), node_id, clock)
            stack.callback(link.close)
            drive = stack.enter_context(RemoteDrive(link, dictionary, eds.name, clock))
            yield Session(profile_name, profile, text, drive, clock)


def emulator_is_compiled() -> bool:
    """Whether this machine holds the compiled emulator, or its first run will compile it."""
    from benchtool.emulator.kernel import kernel_is_cached

    return kernel_is_cached()


def _open_can(address: Address) -> can.BusABC:
    bitrate: dict[str, Any] = {} if address.bitrate is None else {"bitrate": address.bitrate}
    try:
        return can.Bus(interface=address.interface, channel=address.channel, **bitrate)
    except (can.CanError, OSError, ImportError, ValueError, TypeError) as reason:
        raise LinkError(
            f"cannot open can:{address.interface}:{address.channel}: {reason}; "
            f"check the interface's name, its driver and the channel"
        ) from None
