"""A drive is only enabled while its objects show that it watches this host."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest

from benchtool.clock import VirtualClock
from benchtool.drive.remote import RemoteDrive
from benchtool.drive.supervision import HOST_NODE_ID
from benchtool.errors import (
    BenchError,
    CapabilityMissing,
    SdoAbort,
    StateError,
    ValueRefused,
    WriteNotVerified,
)
from benchtool.link.interface import LinkCounters
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.cia402 import State, statusword, transition
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.modes import Mode
from tests.third_party_drives import third_party_eds

ENTRY, SECOND = (0x1016, 1), (0x1016, 2)
ACTION = (0x6007, 0)
CONTROLWORD, STATUSWORD, MODE = (0x6040, 0), (0x6041, 0), (0x6060, 0)
NONE, FAULT, QUICK_STOP = 0, 1, 3
WATCHED = HOST_NODE_ID << 16 | 500
OF_ANOTHER = 5 << 16 | 100


class Slave:
    """A third-party drive: its objects, and the states of CiA 402."""

    def __init__(self, eds: bytes, **held: int) -> None:
        self.dictionary = Dictionary.from_bytes(eds, 1, "any.eds")
        self.held = {variable.key: 0 for variable in self.dictionary}
        self.held[ACTION] = FAULT
        self.written: list[tuple[tuple[int, int], int]] = []
        self.refused: dict[tuple[int, int], int] = {}
        self.deaf: set[tuple[int, int]] = set()
        self.state = State.SWITCH_ON_DISABLED
        self.heartbeats: list[float] = []
        self.clock = VirtualClock()

    def upload(self, index: int, sub: int, *, length: int | None = None, block: bool = False) -> bytes:
        key = index, sub
        if key == STATUSWORD:
            return statusword(self.state).to_bytes(2, "little")
        if self.refused.get(key) == Abort.NO_OBJECT or key not in self.held:
            raise SdoAbort("no such object", Abort.NO_OBJECT)
        variable = self.dictionary[key]
        return (self.held[key] & (1 << variable.type.bits) - 1).to_bytes(variable.type.bits // 8, "little")

    def download(self, index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        key, value = (index, sub), int.from_bytes(data, "little")
        if key in self.refused:
            raise SdoAbort("refused", self.refused[key])
        if key == CONTROLWORD:
            self.state = transition(self.state, value, 0)
        self.written.append((key, value))
        if key not in self.deaf:
            self.held[key] = value

    def host(self, *, allow_unsupervised: bool = False) -> RemoteDrive:
        link: Any = SimpleNamespace(
            upload=self.upload,
            download=self.download,
            nmt=lambda _: None,
            send_heartbeat=lambda: self.heartbeats.append(self.clock.now_s()),
            emergencies=lambda: (),
            counters=LinkCounters(),
        )
        return RemoteDrive(
            link, self.dictionary, "any.eds", self.clock, allow_unsupervised=allow_unsupervised
        )

    @contextmanager
    def enabled_by_host(self, **options: bool) -> Iterator[RemoteDrive]:
        with self.host(**options) as drive:
            drive.enable(Mode.VELOCITY)
            yield drive

    @property
    def enabled(self) -> bool:
        return any(key == CONTROLWORD and value & 0x8 for key, value in self.written)

    def writes_to(self, key: tuple[int, int]) -> list[int]:
        return [value for written, value in self.written if written == key]


def _no_heartbeat_object(slave: Slave) -> None:
    slave.dictionary = Dictionary.from_bytes(third_party_eds(without=["1016sub1", "1016sub2"]), 1, "any.eds")


def _cannot_be_written(slave: Slave) -> None:
    read_only = {section: {"AccessType": "ro"} for section in ("1016sub1", "1016sub2")}
    slave.dictionary = Dictionary.from_bytes(third_party_eds(changed=read_only), 1, "any.eds")


def _listed_and_not_there(slave: Slave) -> None:
    slave.refused = {ENTRY: Abort.NO_OBJECT, SECOND: Abort.NO_OBJECT}


def _refuses_the_value(slave: Slave) -> None:
    slave.refused = {ENTRY: Abort.READ_ONLY, SECOND: Abort.READ_ONLY}


def _keeps_what_it_had(slave: Slave) -> None:
    slave.deaf = {ENTRY, SECOND}


def _all_in_use(slave: Slave) -> None:
    slave.held |= {ENTRY: OF_ANOTHER, SECOND: OF_ANOTHER + (1 << 16)}


def _action_refused(slave: Slave) -> None:
    slave.held[ACTION] = NONE
    slave.refused = {ACTION: Abort.READ_ONLY}


def _action_not_kept(slave: Slave) -> None:
    slave.held[ACTION] = NONE
    slave.deaf = {ACTION}


CANNOT = [
    (_no_heartbeat_object, CapabilityMissing),
    (_cannot_be_written, CapabilityMissing),
    (_listed_and_not_there, CapabilityMissing),
    (_refuses_the_value, SdoAbort),
    (_keeps_what_it_had, WriteNotVerified),
    (_all_in_use, CapabilityMissing),
    (_action_refused, SdoAbort),
    (_action_not_kept, WriteNotVerified),
]


@pytest.mark.parametrize(("spoilt", "error"), CANNOT)
@pytest.mark.parametrize("way", ["connect", "enable", "enable twice"])
def test_a_drive_that_cannot_be_supervised_is_not_enabled(
    spoilt: Callable[[Slave], None], error: type[BenchError], way: str
) -> None:
    slave = Slave(third_party_eds())
    spoilt(slave)
    with slave.host() as drive:
        for _ in range(2 if way == "enable twice" else 1):
            with pytest.raises(error):
                drive.connect() if way == "connect" else drive.enable(Mode.VELOCITY)
    assert not slave.enabled
    assert slave.heartbeats == []
    if spoilt in (_action_refused, _action_not_kept):
        assert slave.held[ENTRY] == 0, "it is left as it was found"
    assert slave.state is State.SWITCH_ON_DISABLED


@pytest.mark.parametrize(("spoilt", "error"), CANNOT)
def test_a_profile_may_let_it_run_and_then_says_why(
    spoilt: Callable[[Slave], None], error: type[BenchError]
) -> None:
    slave = Slave(third_party_eds())
    spoilt(slave)
    with slave.enabled_by_host(allow_unsupervised=True) as drive:
        assert slave.enabled
        stated = drive.supervision.to_json()
        assert stated["armed"] is False
        assert stated["reason"]
        assert slave.writes_to(ACTION) == [], "it is the drive's own choice then"
    assert slave.state is State.SWITCH_ON_DISABLED


def test_armed_is_what_the_drive_reads_back() -> None:
    slave = Slave(third_party_eds())
    with slave.enabled_by_host() as drive:
        assert slave.held[ENTRY] == WATCHED == drive.number("0x1016:1")
        assert slave.heartbeats == [0.0], "the first heartbeat begins the drive's watch, before it is enabled"
        drive.wait(1.0)
        assert len(slave.heartbeats) == 11
        assert drive.supervision.to_json() == {}
    assert slave.held[ENTRY] == 0
    assert slave.writes_to(SECOND) == []
    before = len(slave.heartbeats)
    slave.clock.wait(1.0)
    assert len(slave.heartbeats) == before


@pytest.mark.parametrize("timeout_s", [0.06, 0.5, 2.0])
def test_the_heartbeat_comes_at_least_three_times_in_a_timeout(timeout_s: float) -> None:
    slave = Slave(third_party_eds())
    with slave.host() as drive:
        drive.supervise(timeout_s)
        assert slave.held[ENTRY] == HOST_NODE_ID << 16 | round(timeout_s * 1e3)
        drive.wait(3 * timeout_s)
        assert len(slave.heartbeats) >= 9
        drive.enable(Mode.TORQUE)
        assert slave.held[ENTRY] & 0xFFFF == round(timeout_s * 1e3)


@pytest.mark.parametrize("timeout_s", [0.0, -1.0, 0.0004, 2.001, 65.0, 131.1, float("nan"), float("inf")])
def test_a_timeout_that_watches_no_host_is_refused(timeout_s: float) -> None:
    slave = Slave(third_party_eds())
    with slave.host(allow_unsupervised=True) as drive, pytest.raises(ValueRefused, match="a link timeout of"):
        drive.supervise(timeout_s)
    assert slave.written == []
    assert slave.heartbeats == []


@pytest.mark.parametrize("timeout_s", [0.001, 2.0])
def test_the_whole_range_can_be_had(timeout_s: float) -> None:
    slave = Slave(third_party_eds())
    with slave.host() as drive:
        drive.supervise(timeout_s)
        assert slave.held[ENTRY] == HOST_NODE_ID << 16 | round(timeout_s * 1e3)


def test_a_host_that_arms_again_has_one_heartbeat() -> None:
    slave = Slave(third_party_eds())
    with slave.host() as drive:
        for _ in range(3):
            drive.supervise()
        before = len(slave.heartbeats)
        drive.wait(1.0)
        assert len(slave.heartbeats) == before + 10


@pytest.mark.parametrize("enabled", [False, True])
def test_a_refusal_because_of_the_state_is_another_hosts_doing_only_while_it_runs(enabled: bool) -> None:
    slave = Slave(third_party_eds())
    slave.refused = {ENTRY: Abort.DEVICE_STATE}
    slave.state = State.OPERATION_ENABLED if enabled else State.READY_TO_SWITCH_ON
    with slave.host() as drive, pytest.raises(StateError if enabled else SdoAbort):
        drive.supervise()
    slave.refused = {ENTRY: Abort.READ_ONLY}
    with slave.host() as drive, pytest.raises(SdoAbort):
        drive.supervise()
    assert slave.heartbeats == []


def test_a_profile_that_allows_it_need_not_make_use_of_it() -> None:
    slave = Slave(third_party_eds())
    with slave.enabled_by_host(allow_unsupervised=True) as drive:
        assert slave.held[ENTRY] == WATCHED
        assert drive.supervision.to_json() == {"armed": True, "reason": ""}


@pytest.mark.parametrize("own_first", [False, True])
def test_an_entry_of_another_node_is_left_to_it(own_first: bool) -> None:
    slave = Slave(third_party_eds())
    slave.held |= {ENTRY: OF_ANOTHER, SECOND: HOST_NODE_ID << 16 | 100 if own_first else 0}
    with slave.enabled_by_host():
        assert slave.held[ENTRY] == OF_ANOTHER
        assert slave.held[SECOND] == WATCHED
    assert slave.held[ENTRY] == OF_ANOTHER
    assert slave.held[SECOND] == 0


@pytest.mark.parametrize("absent", [ENTRY, SECOND])
def test_an_entry_that_the_file_lists_and_the_drive_has_not_is_passed_over(absent: tuple[int, int]) -> None:
    slave = Slave(third_party_eds())
    slave.refused = {absent: Abort.NO_OBJECT}
    with slave.enabled_by_host():
        assert slave.held[SECOND if absent == ENTRY else ENTRY] == WATCHED


@pytest.mark.parametrize("access", ["ro", "wo"])
def test_an_entry_that_cannot_be_written_and_read_back_is_passed_over(access: str) -> None:
    slave = Slave(third_party_eds(changed={"1016sub2": {"AccessType": access}}))
    slave.held[ENTRY] = OF_ANOTHER
    with slave.host() as drive, pytest.raises(CapabilityMissing, match=r"watches another node \(5\)"):
        drive.enable(Mode.VELOCITY)
    assert slave.written == []


@pytest.mark.parametrize("left", [HOST_NODE_ID << 16 | 100, 5 << 16, 300])
def test_no_node_is_named_twice_and_what_is_out_of_use_is_taken(left: int) -> None:
    """An entry without a node, or without a time, is not in use (CiA 301, object 0x1016)."""
    slave = Slave(third_party_eds())
    slave.held |= {ENTRY: OF_ANOTHER, SECOND: left}
    with slave.enabled_by_host():
        assert slave.held[SECOND] == WATCHED
    swapped = Slave(third_party_eds())
    swapped.held |= {ENTRY: 0, SECOND: HOST_NODE_ID << 16 | 100}
    with swapped.enabled_by_host():
        assert swapped.held[ENTRY] == 0, "two entries of one node are refused by a drive"
        assert swapped.held[SECOND] == WATCHED


@pytest.mark.parametrize("code", [OF_ANOTHER, HOST_NODE_ID << 16 | 700])
def test_a_drive_that_another_host_has_enabled_is_left_alone(code: int) -> None:
    slave = Slave(third_party_eds())
    slave.held[ENTRY] = code
    slave.state = State.OPERATION_ENABLED
    told = rf"another host .* \(node {code >> 16}, timeout {code & 0xFFFF} ms"
    with slave.host(allow_unsupervised=True) as drive, pytest.raises(StateError, match=told):
        drive.connect()
    assert slave.written == []
    assert slave.state is State.OPERATION_ENABLED


def test_a_drive_that_would_do_nothing_without_its_host_is_set_to_fault_meanwhile() -> None:
    slave = Slave(third_party_eds())
    slave.held[ACTION] = NONE
    with slave.enabled_by_host():
        assert slave.held[ACTION] == FAULT
    assert slave.held[ACTION] == NONE
    assert slave.writes_to(ACTION) == [FAULT, NONE]


@pytest.mark.parametrize("action", [FAULT, 2, QUICK_STOP])
def test_an_action_that_stops_the_motor_is_the_drives_own_choice(action: int) -> None:
    slave = Slave(third_party_eds())
    slave.held[ACTION] = action
    with slave.enabled_by_host():
        assert slave.held[ACTION] == action
    assert slave.writes_to(ACTION) == []


@pytest.mark.parametrize("without", ["6007", "listed"])
def test_a_drive_without_the_option_reacts_as_its_maker_chose(without: str) -> None:
    slave = Slave(third_party_eds(without=["6007"] if without == "6007" else []))
    slave.refused = {ACTION: Abort.NO_OBJECT}
    with slave.enabled_by_host():
        assert slave.held[ENTRY] == WATCHED
        assert slave.state is State.OPERATION_ENABLED


@pytest.mark.parametrize("lost", [ENTRY, ACTION])
def test_what_the_drive_has_lost_since_is_armed_again_before_it_is_enabled(lost: tuple[int, int]) -> None:
    """A reset of the drive, or another master, ends what was armed."""
    slave = Slave(third_party_eds())
    with slave.host() as drive:
        drive.connect()
        slave.held[lost] = 0
        drive.enable(Mode.VELOCITY)
        assert slave.held[ENTRY] == WATCHED
        assert slave.held[ACTION] == FAULT
        drive.disable()
        slave.held[lost] = 0
        slave.refused[lost] = Abort.READ_ONLY
        with pytest.raises(SdoAbort):
            drive.enable(Mode.VELOCITY)
        assert slave.state is State.SWITCH_ON_DISABLED


def test_a_host_that_was_silent_speaks_before_it_enables() -> None:
    slave = Slave(third_party_eds())
    with slave.host() as drive:
        drive.connect()
        drive.stop_heartbeat()
        drive.wait(1.0)
        before = len(slave.heartbeats)
        armed = len(slave.writes_to(ENTRY))
        drive.enable(Mode.VELOCITY)
        assert len(slave.heartbeats) == before + 1
        assert len(slave.writes_to(ENTRY)) == armed, "a loss that the drive has latched is not wiped out"


def test_a_limit_that_leaves_no_room_for_a_node_is_not_the_objects() -> None:
    """Some files limit 0x1016 to the 16 bits of its time."""
    slave = Slave(third_party_eds(changed={"1016sub1": {"LowLimit": "0", "HighLimit": "65535"}}))
    with slave.enabled_by_host():
        assert slave.held[ENTRY] == WATCHED


def test_a_failed_write_of_the_end_leaves_the_watch_armed_and_the_host_silent() -> None:
    slave = Slave(third_party_eds())
    with slave.enabled_by_host():
        slave.refused = {ENTRY: Abort.DEVICE_STATE}
    assert slave.held[ENTRY] == WATCHED
    before = len(slave.heartbeats)
    slave.clock.wait(1.0)
    assert len(slave.heartbeats) == before


@pytest.mark.parametrize(("supported", "code"), [(0x24, 3), (0x104, 3), (0x100, 9), (0x0, 3), (0x8, 3)])
def test_the_cyclic_mode_is_asked_for_where_the_profile_mode_is_missing(supported: int, code: int) -> None:
    slave = Slave(third_party_eds())
    slave.held[0x6502, 0] = supported
    with slave.enabled_by_host():
        assert slave.held[MODE] == code


# ---- ways out on which the drive does not confirm ---------------------------------------------------------


def test_a_drive_that_does_not_confirm_is_left_watching_a_host_that_is_silent() -> None:
    slave = Slave(third_party_eds())
    slave.held[ACTION] = NONE
    with (
        pytest.raises(StateError, match="heartbeat ends now"),
        slave.host() as drive,
        drive.enabled(Mode.VELOCITY),
    ):
        slave.refused = {CONTROLWORD: Abort.DEVICE_STATE}
    assert slave.state is State.OPERATION_ENABLED
    assert slave.held[ENTRY] == WATCHED, "the watch is all that stops it now"
    assert slave.held[ACTION] == FAULT
    before = len(slave.heartbeats)
    slave.clock.wait(1.0)
    assert len(slave.heartbeats) == before


def test_a_host_that_stays_after_that_is_silent_too() -> None:
    slave = Slave(third_party_eds())
    with slave.host() as drive:
        drive.enable(Mode.VELOCITY)
        slave.refused = {CONTROLWORD: Abort.DEVICE_STATE}
        with pytest.raises(StateError, match="heartbeat ends now"):
            drive.disable()
        before = len(slave.heartbeats)
        slave.clock.wait(1.0)
        assert len(slave.heartbeats) == before
        slave.refused = {}
    assert slave.state is State.SWITCH_ON_DISABLED, "the way out tries again"


class _Interrupting:
    """An observer at whose first look Ctrl-C comes, once it is ready."""

    ready = False

    def state(self, state: State, tick: int | None) -> None:
        if self.ready:
            self.ready = False
            raise KeyboardInterrupt

    def emergency(self, emergency: object, tick: int | None) -> None:
        pass


def test_an_interrupt_while_it_is_disabled_keeps_it_from_nothing() -> None:
    slave, interrupting = Slave(third_party_eds()), _Interrupting()
    with (
        pytest.raises(KeyboardInterrupt),
        slave.host() as drive,
        drive.observed(interrupting),
        drive.enabled(Mode.VELOCITY),
    ):
        interrupting.ready = True
    assert slave.state is State.SWITCH_ON_DISABLED
    assert slave.held[ENTRY] == 0
