"""What a wire declares: how it is spelled, opened and searched, and how an emulated drive offers it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import TYPE_CHECKING

from benchtool.bench.wires.address import Address, AddressSyntax

if TYPE_CHECKING:
    from benchtool.clock import Clock
    from benchtool.emulator import EmulatedBench
    from benchtool.emulator.ports import Traffic
    from benchtool.emulator.servers import OnGone
    from benchtool.link import Found, Link, Port
    from benchtool.profile import Profile
    from benchtool.telemetry import FrameLog


class FarEnd(Enum):
    """What is at the other end of a wire."""

    DRIVE = auto()
    EMULATED_DRIVE = auto()
    """In this process: it is powered up with every session, and its bench can be altered."""

    RECORDING = auto()


@dataclass(frozen=True)
class Opening:
    """Options of a session for the wire that it is opened over.

    `seed`, `real_time` and `first_tick` are of an emulated bench, as `open_session` takes them; `frames` logs
    the frames of a wire that carries frames.
    """

    profile: Profile
    node_id: int
    seed: int = 0
    real_time: bool = False
    first_tick: int = 0
    frames: FrameLog | None = None
    note: Callable[[str], None] = lambda _: None


@dataclass(frozen=True)
class Connection:
    """The way to a drive.

    If it `reopens`, each call of `open_link` opens a link, which the session closes and opens again if it was
    lost; otherwise there is one link, which is closed where it was opened. `bench` is what the drive stands
    on, if that is emulated in this process.
    """

    clock: Clock
    open_link: Callable[[], Link]
    reopens: bool = True
    bench: EmulatedBench | None = None


@dataclass(frozen=True)
class Offered:
    """A wire that an emulated drive offers to other programs; `link` is its address, as `--link` takes it."""

    link: str
    traffic: Callable[[], Traffic]


@dataclass(frozen=True)
class StreamLimits:
    """What a stream over a wire may be, in the words of the help: most signals, most records per second."""

    over: str
    signals: str
    rate: str


Connect = Callable[[ExitStack, Address, Opening], Connection]
"""Make the way to a drive; what it holds is given back by the stack.

Raises:
    LinkError: the adapter, the port or the recording cannot be opened.
"""

Offer = Callable[["EmulatedBench", "Port", str, int, "OnGone"], Offered]
"""Serve an emulated drive on a byte port, given its name for clients and the drive's node id."""

Discover = Callable[[Address, float], "list[Found]"]
"""Drives that answer at an address within a time in seconds.

Raises:
    LinkError: none does, or the adapter or the port cannot be opened.
"""


@dataclass(frozen=True)
class Wire:
    """One wire; what it cannot do stays None. Its callables import what they need when they are called.

    How it carries streams and setpoints is for the links to say that `connect` and `host_link` open.

    Raises:
        ValueError: it has addresses and cannot open them, or the reverse.

    Attributes:
        name: what `emulated?wire=` calls it.
        syntax, connect: of its own addresses, which lead to `far_end`; both, or neither.
        carries_frames: what travels are CAN frames: they can be kept, and others can listen.
        stream: what a stream over it may be.
        host_link: makes what opens a link to an emulated drive in this process.
        offers: ways to offer an emulated drive to other programs, by their names.
        own_places: addresses of this computer that may lead to drives, for a scan.
        discover: looks for drives.
    """

    name: str
    syntax: AddressSyntax | None = None
    connect: Connect | None = None
    far_end: FarEnd = FarEnd.DRIVE
    carries_frames: bool = False
    stream: StreamLimits | None = None
    host_link: Callable[[EmulatedBench, Opening], Callable[[], Link]] | None = None
    offers: Mapping[str, Offer] = field(default_factory=dict)
    own_places: Callable[[], Sequence[str]] = lambda: ()
    discover: Discover | None = None

    def __post_init__(self) -> None:
        if (self.syntax is None) != (self.connect is None):
            raise ValueError(
                f"wire '{self.name}' has one of syntax and connect, both or neither are expected"
            )
