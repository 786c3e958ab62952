"""The emulated drive as a device: in real time, on wires that other programs open.

Beside `benchtool.bench.session` this is what knows both the emulated drive and how a host addresses it.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchtool.bench.wires import registry
from benchtool.bench.wires.failures import naming_wires
from benchtool.errors import EnvironmentFailure, LinkError, UsageError
from benchtool.profile import load_profile

if TYPE_CHECKING:
    from benchtool.emulator import DriveStatus, EmulatedBench
    from benchtool.emulator.ports import PtyPort, TcpPort, Traffic

STEP_S = 0.002
"""Wall-clock seconds for which a frame may wait for the drive's time to go on."""

_CATCH_UP_S = 0.1  # a drive that catches up for longer could take that for a lost host
_EVERYWHERE = ("0.0.0.0", "::")
_TERMINALS = ("/dev/pts/", "/dev/ttys")  # of Linux, of macOS


@dataclass(frozen=True)
class Endpoint:
    """A wire to be offered: a pseudo-terminal, or a TCP port if `tcp` is an address and a number.

    `wire` is the name of an offer of a `Wire`: `serial`, `slcan` or another. Of number 0 the system chooses
    one that is free. `name` is a symbolic link to the pseudo-terminal.
    """

    wire: str
    tcp: tuple[str, int] | None = None
    name: Path | None = None


@dataclass(frozen=True)
class ServedWire:
    """A wire that is open; `link` is its address, as `--link` takes it."""

    wire: str
    place: str
    link: str
    traffic: Callable[[], Traffic]


@dataclass(frozen=True)
class ServedDrive:
    """A powered drive; its time only passes in `run`."""

    node_id: int
    speed: float
    wires: tuple[ServedWire, ...]
    status: Callable[[], DriveStatus]
    _wait: Callable[[float], None]

    def run(self, duration_s: float) -> None:
        """Run for so many seconds of the wall clock."""
        self._wait(duration_s * self.speed)


@contextmanager
def serve(
    profile_name: str,
    endpoints: Sequence[Endpoint],
    *,
    seed: int = 0,
    speed: float = 1.0,
    load_torque_Nm: float = 0.0,
    hold_omega_m_rad_s: float | None = None,
    faults: Sequence[str] = (),
    note: Callable[[str], None] = lambda _: None,
) -> Iterator[ServedDrive]:
    """Power an emulated drive up and offer it on these wires until the `with` block ends.

    Args:
        profile_name: a shipped profile's name or a TOML file.
        seed: of the sensors' noise.
        speed: drive seconds in a second of the wall clock.
        load_torque_Nm: of the load machine, against positive rotation, while the drive is enabled.
        hold_omega_m_rad_s: speed at which the load machine turns the shaft instead.
        faults: injected at their seconds after power-up, as `Faults.inject` takes them.
        note: called with a message when a wire is lost, or the drive is compiled.

    Raises:
        ProfileError: the profile cannot be read, or describes no emulated bench.
        UsageError: `speed` is not positive, or there is no such wire or fault.
        LinkError: a wire cannot be offered.
        EnvironmentFailure: this system has no pseudo-terminals.
        PlugInError: the wire of another package fails.
    """
    from benchtool.emulator import EmulatedBench

    if not speed > 0.0:
        raise UsageError(f"a speed of {speed:g} cannot be: 1 is that of the wall clock, choose one above 0")
    profile = load_profile(profile_name)
    with naming_wires(), ExitStack() as stack:
        bench = EmulatedBench(
            profile,
            seed=seed,
            paced=True,
            speed=speed,
            step_s=STEP_S * speed,
            catch_up_s=_CATCH_UP_S,
            has_bus=False,
            note=note,
        )
        stack.callback(bench.close)
        if hold_omega_m_rad_s is not None:
            bench.load.hold(hold_omega_m_rad_s)
        elif load_torque_Nm:
            # A load that pulls at a motor without current would have it run away.
            bench.clock.follow(lambda _: bench.load.apply(load_torque_Nm if bench.enabled else 0.0))
        bench.warm_up()  # before there is a client to wait for it
        wires = tuple(_offer(stack, bench, each, profile.drive.node_id, note) for each in endpoints)
        for fault in faults:
            note(f"armed: {bench.faults.inject(fault)}")
        yield ServedDrive(profile.drive.node_id, speed, wires, bench.status, bench.clock.wait)


def _offer(
    stack: ExitStack, bench: EmulatedBench, endpoint: Endpoint, node_id: int, note: Callable[[str], None]
) -> ServedWire:
    offer = registry.offer_named(endpoint.wire)
    port, place = _open(stack, endpoint)

    def gone(reason: OSError) -> None:
        note(f"{place} is lost: {reason}; the drive runs on")

    offered = offer(bench, port, place, node_id, gone)
    return ServedWire(endpoint.wire, place, offered.link, offered.traffic)


def _open(stack: ExitStack, endpoint: Endpoint) -> tuple[PtyPort | TcpPort, str]:
    """Return a port, and where its clients find it."""
    if endpoint.tcp is not None:
        from benchtool.emulator.ports import TcpPort

        host, number = endpoint.tcp
        try:
            listening = TcpPort(host, number)
        except (OSError, OverflowError) as reason:
            raise LinkError(
                f"cannot listen at {host}, port {number}: {reason}; "
                f"choose an address of this computer and a port that is free, or port 0"
            ) from None
        shown = socket.gethostname() if host in _EVERYWHERE else host
        shown = f"[{shown}]" if ":" in shown else shown
        return listening, f"socket://{shown}:{listening.address[1]}"
    try:
        from benchtool.emulator.ports import PtyPort
    except ImportError:
        raise EnvironmentFailure("this system has no pseudo-terminals: offer TCP ports instead") from None
    terminal = PtyPort()
    if endpoint.name is None:
        return terminal, terminal.path
    try:
        stack.enter_context(_named(endpoint.name, terminal.path))
    except BaseException:
        terminal.close()
        raise
    return terminal, str(endpoint.name.absolute())


@contextmanager
def _named(name: Path, path: str) -> Iterator[None]:
    """A symbolic link for the length of a `with` block, in place of one that an earlier run left behind."""
    try:
        if name.is_symlink() and str(name.readlink()).startswith(_TERMINALS):
            name.unlink()
        name.symlink_to(path)
    except OSError as reason:
        raise LinkError(
            f"cannot make the symbolic link {name}: {reason.strerror}; choose a name that is free"
        ) from None
    try:
        yield
    finally:
        if name.is_symlink() and os.readlink(name) == path:
            name.unlink()
