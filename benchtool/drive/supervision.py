"""Link supervision: the drive stops the motor when this host falls silent.

The drive consumes the host's heartbeat (CiA 301, object 0x1016); what it does without is its abort connection
option (CiA 402-2, object 0x6007), where it has one. Armed is what the drive reads back, not what was written.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Final

from benchtool.clock import Timer
from benchtool.drive.capabilities import Capability
from benchtool.drive.states import Cia402Node
from benchtool.errors import (
    BenchError,
    CapabilityMissing,
    SdoAbort,
    StateError,
    ValueRefused,
    WriteNotVerified,
)
from benchtool.protocol import State
from benchtool.protocol.canopen import Abort, ErrorCode
from benchtool.protocol.dictionary import DataType, Role, Variable

HEARTBEAT_S: Final = 0.1
LINK_TIMEOUT_S: Final = 0.5
"""Where the profile states none."""
LONGEST_TIMEOUT_S: Final = 2.0
"""A drive that may lose its host for longer is not watched."""
HOST_NODE_ID: Final = 127

_HEARD, _LOST = "alive", "lost"  # of the object link_state
_WATCH_S = 0.05
_NO_ACTION, _FAULT = 0, 1  # of the abort connection option
_SHORTEST_S = 0.001
_REACTION_S = 0.1


class LinkSupervision:
    """What has a drive watch this host, and this host's heartbeat.

    Args:
        drive: the drive that is to watch.
        allow_unsupervised: go on where it cannot; `unsupervised` then says why.
        timeout_s: that it is armed with, if no caller asks for another.
    """

    def __init__(
        self, drive: Cia402Node, *, allow_unsupervised: bool, timeout_s: float = LINK_TIMEOUT_S
    ) -> None:
        self.allow_unsupervised = allow_unsupervised
        self.unsupervised = ""
        self._drive = drive
        self._timeout_s = timeout_s
        self._heartbeat: Timer | None = None
        self._entry: Variable | None = None
        self._overridden: Variable | None = None

    @property
    def timeout_s(self) -> float:
        """Time without a heartbeat of this host after which an armed drive stops the motor."""
        return self._timeout_s

    def to_json(self) -> dict[str, bool | str]:
        """As a manifest keeps it, of a drive that may run unsupervised; empty of any other."""
        if not self.allow_unsupervised:
            return {}
        return {"armed": self._entry is not None and not self.unsupervised, "reason": self.unsupervised}

    # ---- arming -------------------------------------------------------------------------------------------

    def arm(self, timeout_s: float | None = None) -> None:
        """Send the host's heartbeat, and have the drive stop the motor when it is missing for `timeout_s`, by
        default the time that was asked for last.

        Raises:
            ValueRefused: a timeout that 0x1016 cannot have, or that is as good as none.
            CapabilityMissing: the drive has no such object, or has it in use for other nodes.
            SdoAbort, WriteNotVerified: the drive does not take it.
            StateError: another host has the drive enabled.
        """
        timeout_s = self._timeout_s if timeout_s is None else timeout_s
        if not _SHORTEST_S <= timeout_s <= LONGEST_TIMEOUT_S:
            raise ValueRefused(
                f"a link timeout of {timeout_s:g} s: {_SHORTEST_S:g} to {LONGEST_TIMEOUT_S:g} s watch a "
                f"host, choose one within; nothing was sent"
            )
        self.stop_sending()
        self._timeout_s = timeout_s
        self._entry, self.unsupervised = None, ""
        try:
            self._entry = self._armed_entry()
        except (CapabilityMissing, SdoAbort, WriteNotVerified) as failed:
            if not self.allow_unsupervised:
                raise
            self.unsupervised = str(failed)
        self._keep_alive()

    def require(self) -> None:
        """Have the drive watch this host now, whatever has happened to it since it was armed.

        Raises:
            BenchError: as `arm`.
        """
        if not (self.unsupervised or self._held()):
            self.arm()
        elif self._heartbeat is None:
            self._keep_alive()

    def prove(self) -> None:
        """Fall silent for longer than the drive's timeout, with its power stage off, and see that it notices.

        Afterwards it watches this host again, and the loss is forgotten. A drive that may run unsupervised
        and does is not asked.

        Raises:
            CapabilityMissing: it did not notice.
            StateError: it is enabled, or stays in fault.
        """
        drive = self._drive
        if self.unsupervised:
            return
        if drive.state().power_stage_on:
            raise StateError(
                "the power stage is on and the watchdog is proven with it off: disable the drive first"
            )
        drive.emergencies()
        self.stop_sending()
        drive.clock.wait(self._timeout_s + _REACTION_S)
        codes = [each.code for each in drive.emergencies()]
        lost = "link_state" in drive.dictionary and drive.read("link_state") == _LOST
        if not (lost or ErrorCode.HEARTBEAT in codes):
            raise CapabilityMissing(
                f"the drive did not notice that this host was silent for "
                f"{self._timeout_s + _REACTION_S:g} s, {self._timeout_s:g} s are its timeout (0x1016): its "
                f"watchdog is not proven and the drive was not enabled; look for what feeds it besides"
            )
        drive.reset_fault()
        drive.emergencies()
        self._keep_alive()

    def _held(self) -> bool:
        """Return whether the drive says that it still watches this host: a reset, or another master, may end
        it."""
        if self._entry is None:
            return False
        code = int(self._drive.number(self._entry))
        return _watches_host(code) and self._action() != _NO_ACTION

    @property
    def _code(self) -> int:
        """Value of an entry of 0x1016 that has the drive watch this host: node and milliseconds."""
        return HOST_NODE_ID << 16 | round(self._timeout_s * 1000.0)

    def _armed_entry(self) -> Variable:
        """Return the entry of 0x1016 that has this host in it, as read back."""
        drive = self._drive
        drive.capabilities.require(Capability.SUPERVISED, purpose="enabling the drive")
        entry = self._usable_entry()
        self._arm_action()  # first: a watch without a reaction is none
        try:
            drive.write(entry, self._code)
        except SdoAbort as refused:
            # Our drive takes it at any time but while the power stage is on.
            if refused.code == Abort.DEVICE_STATE and drive.state() is State.OPERATION_ENABLED:
                raise self._supervised_by_another(int(drive.number(entry))) from refused
            raise
        return entry

    def _usable_entry(self) -> Variable:
        """Return the entry that names this host already, else the first one that is not in use.

        Two entries must not name the same node (CiA 301, object 0x1016).
        """
        drive, first = self._drive, self._drive.dictionary[Role.CONSUMER_HEARTBEAT]
        if "link_state" in drive.dictionary:  # which has told that no other host is heard
            return _plain(first)
        entries = [each for each in drive.dictionary if each.index == first.index and each.sub >= first.sub]
        usable = [_plain(each) for each in entries if each.readable and each.writable]
        held = {each.sub: code for each in usable if (code := drive.optional_number(each)) is not None}
        usable = [each for each in usable if each.sub in held]
        used = [code for code in held.values() if _node(code) and _timeout_ms(code)]
        if used and drive.state().power_stage_on:
            raise self._supervised_by_another(used[0])
        own = [each for each in usable if _node(held[each.sub]) == HOST_NODE_ID]
        free = [each for each in usable if held[each.sub] not in used]
        if not own + free:
            nodes = ", ".join(str(_node(code)) for code in used)
            seen = (
                f"every entry watches another node ({nodes})"
                if nodes
                else "the drive lacks objects that its EDS lists"
            )
            raise CapabilityMissing(
                f"no '{Capability.SUPERVISED}': an entry of 0x{first.index:04X} is needed for this host, and "
                f"{seen}: free one; the drive was not enabled"
            )
        return (own + free)[0]

    def _action(self) -> int | None:
        """Return what the drive does without this host; None where it does not tell."""
        return self._drive.optional_number(Role.ABORT_CONNECTION_OPTION)

    def _arm_action(self) -> None:
        """Have the drive go into fault without this host, if it would do nothing."""
        if self._action() != _NO_ACTION:
            return
        option = self._drive.dictionary[Role.ABORT_CONNECTION_OPTION]
        if self.allow_unsupervised:
            self.unsupervised = f"'{option.name}' ({option.label}) has the drive do nothing without its host"
            return
        self._drive.write(option, _FAULT)
        self._overridden = option

    # ---- silence ------------------------------------------------------------------------------------------

    def _keep_alive(self) -> None:
        period_s = min(HEARTBEAT_S, self._timeout_s / 4.0)  # three of them may be lost
        self._heartbeat = self._drive.clock.call_every(period_s, self._send_heartbeat)

    def _send_heartbeat(self) -> None:
        self._drive.link.send_heartbeat()  # over the link of now: a reconnected drive has another

    def stop_sending(self) -> None:
        """End the heartbeat; a drive that is supervised stops the motor after its timeout."""
        heartbeat, self._heartbeat = self._heartbeat, None
        if heartbeat is not None:
            heartbeat.cancel()

    def disarm(self) -> None:
        """Set the drive back before the heartbeat ends, so that it takes no end for a loss."""
        entry, self._entry = self._entry, None
        if entry is not None and self._heartbeat is not None:
            with suppress(BenchError):  # then the drive notices that the host has gone, and says so
                self._drive.write(entry, 0)
        option, self._overridden = self._overridden, None
        if option is not None:
            with suppress(BenchError):  # then it goes into fault without a host, which is the safer way
                self._drive.write(option, _NO_ACTION)

    # ---- other hosts --------------------------------------------------------------------------------------

    def require_no_other_host(self) -> None:
        """Refuse a drive that hears a host already, one that fell silent a moment ago excepted.

        Two hosts cannot supervise it both: the first that leaves would take the other's supervision along.

        Raises:
            StateError: another host supervises the drive; nothing was changed.
        """
        drive = self._drive
        if self._heartbeat is not None or "link_state" not in drive.dictionary:
            return
        if drive.read("link_state") != _HEARD:
            return
        code = drive.optional_number(Role.CONSUMER_HEARTBEAT) or 0
        deadline_s = drive.clock.now_s() + _timeout_ms(int(code)) / 1000.0 + _WATCH_S
        while drive.clock.now_s() < deadline_s:
            drive.clock.wait(_WATCH_S)
            if drive.read("link_state") != _HEARD:
                drive.emergencies()  # the loss of that host is not one of this host's
                return
        raise self._supervised_by_another(int(code))

    def _supervised_by_another(self, configured: int) -> StateError:
        return StateError(
            f"another host supervises this drive (node {_node(configured)}, timeout "
            f"{_timeout_ms(configured)} ms), which is in '{self._drive.state().value}': end what runs there "
            f"first, or only look, as record, live and info do; nothing was changed"
        )


def _node(code: int) -> int:
    """Return the node that an entry of 0x1016 watches; 0 of one that is not in use."""
    return code >> 16 & 0x7F


def _timeout_ms(code: int) -> int:
    """Return the time after which that node is lost; 0 of an entry that is not in use."""
    return code & 0xFFFF


def _watches_host(code: int) -> bool:
    return _node(code) == HOST_NODE_ID and 0 < _timeout_ms(code) <= LONGEST_TIMEOUT_S * 1000.0


def _plain(entry: Variable) -> Variable:
    """Return an entry of 0x1016 as CiA 301 codes it: some vendors' files limit it to a time, without a
    node."""
    return replace(
        entry, type=DataType.U32, unit="", factor=1.0, raw_minimum=None, raw_maximum=None, values=None
    )
