"""The drive is disabled at every exit."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from benchtool.drive import RemoteDrive
from benchtool.drive.states import Cia402Node
from benchtool.errors import CapabilityMissing, DriveFault, SdoAbort, StateError, WriteNotVerified
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode

from .conftest import Wire, over_both_wires

NODE = 1
TARGET_VELOCITY = 0x60FF, 0


def _statusword(wire: Wire) -> int:
    """As an observer reads it, without the host."""
    wire.frames()
    wire.send(0x600 + NODE, 0x40, 0x41, 0x60, 0x00, 0, 0, 0, 0)
    ((_, answer),) = [frame for frame in wire.frames() if frame[0] == 0x580 + NODE]
    return int.from_bytes(answer[4:6], "little")


def _is_enabled(wire: Wire) -> bool:
    return _statusword(wire) & 0x6F == 0x27


def _run_up(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.VELOCITY)
    drive.write("omega_m_command", 15.71)
    drive.wait(0.3)
    assert _is_enabled(wire)
    assert drive.number("omega_m") == pytest.approx(15.71, abs=0.5)


@over_both_wires
def test_leaving_the_block_disables(wire: Wire) -> None:
    drive = wire.session.drive
    with drive:
        _run_up(wire)
    assert not _is_enabled(wire)


@over_both_wires
@pytest.mark.parametrize("how", ["disable", "nmt stop", "silence", "fault"])
def test_disabled_means_that_no_switch_moves_and_no_current_flows(wire: Wire, how: str) -> None:
    drive = wire.session.drive
    _run_up(wire)
    assert wire.session.load is not None
    wire.session.load.apply(2.0)
    wire.session.clock.wait(0.1)
    match how:
        case "disable":
            drive.disable()
        case "nmt stop":
            wire.send(0x000, 0x02, NODE)
            wire.send(0x000, 0x80, NODE)
        case "silence":
            drive.stop_heartbeat()
            wire.session.clock.wait(0.6)
        case "fault":
            drive.write("i_trip", 0.1)
    wire.session.load.apply(0.0)
    wire.session.clock.wait(0.05)
    switched = drive.number("switching_count")
    wire.session.clock.wait(0.05)
    assert drive.number("switching_count") == switched
    assert drive.number("torque") == pytest.approx(0.0, abs=0.05)


@over_both_wires
@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit, GeneratorExit])
def test_any_exception_disables_and_passes_through(wire: Wire, error: type[BaseException]) -> None:
    drive = wire.session.drive
    with pytest.raises(error), drive.enabled(Mode.VELOCITY):
        assert _is_enabled(wire)
        raise error
    assert not _is_enabled(wire)


@over_both_wires
def test_the_host_starts_and_leaves_with_targets_of_zero(wire: Wire) -> None:
    _run_up(wire)
    drive = wire.session.drive
    drive.disable()
    assert drive.number("omega_m_command") == 0.0
    drive.write("target_velocity", 12.0)  # what another master may have left
    drive.write("torque_command", 1.0)
    with drive.enabled(Mode.VELOCITY):
        assert drive.number("target_velocity") == drive.number("omega_m_command") == 0.0
        assert drive.number("torque_command") == 0.0
        drive.wait(0.5)
        assert abs(drive.number("omega_m")) < 0.5


@over_both_wires
def test_a_drive_that_keeps_a_target_is_not_enabled(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.write("mode_of_operation", "velocity")
    drive.write("target_velocity", 12.0)
    monkeypatch.setattr(drive.link, "download", _all_but(drive.link.download, TARGET_VELOCITY))
    with pytest.raises(WriteNotVerified, match="'target_velocity' reads back"):
        drive.enable(Mode.VELOCITY)
    assert not _is_enabled(wire)


def _all_but(download: Callable[..., None], ignored: tuple[int, int]) -> Callable[..., None]:
    def without(index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        if (index, sub) != ignored:
            download(index, sub, data, block=block)

    return without


@over_both_wires
@pytest.mark.parametrize(
    ("action", "state"),
    [
        ("fault", State.FAULT),
        ("disable_voltage", State.SWITCH_ON_DISABLED),
        ("quick_stop", State.SWITCH_ON_DISABLED),
    ],
)
def test_a_host_that_falls_silent_is_noticed(wire: Wire, action: str, state: State) -> None:
    drive = wire.session.drive
    drive.write("abort_connection_option", action)
    _run_up(wire)
    drive.stop_heartbeat()
    wire.session.clock.wait(0.38)
    assert drive.state() is State.OPERATION_ENABLED, "SDO reads do not feed the watchdog"
    wire.session.clock.wait(0.5)
    assert drive.state() is state
    assert drive.read("link_state") == "lost"
    assert drive.number("link_losses") == 1


@over_both_wires
def test_a_host_that_leaves_in_good_order_is_not_lost(wire: Wire) -> None:
    drive = wire.session.drive
    with RemoteDrive(drive.link, drive.dictionary, "drive.eds", drive.clock) as guest:
        guest.connect()
        guest.enable(Mode.VELOCITY)
    wire.session.clock.wait(1.0)
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert drive.read("link_state") == "off"
    assert drive.number("link_losses") == 0


@over_both_wires
def test_a_lost_link_is_latched_until_a_fault_reset(wire: Wire) -> None:
    drive = wire.session.drive
    drive.write("abort_connection_option", "disable_voltage")
    _run_up(wire)
    drive.stop_heartbeat()
    wire.session.clock.wait(1.0)
    drive.link.send_heartbeat()
    with pytest.raises(SdoAbort) as refused:
        drive.enable(Mode.VELOCITY)
    assert refused.value.code == Abort.DEVICE_STATE
    drive.reset_fault()
    drive.link.send_heartbeat()
    drive.enable(Mode.VELOCITY)


@over_both_wires
def test_an_unsupervised_start_is_refused_once_supervision_is_asked_for(wire: Wire) -> None:
    drive = wire.session.drive
    drive.write("host_heartbeat", 127 << 16 | 500)
    with pytest.raises(SdoAbort) as refused:
        Cia402Node.enable(drive, Mode.TORQUE)  # as a host that does not arm the supervision by itself
    assert refused.value.code == Abort.DEVICE_STATE


@over_both_wires
@pytest.mark.parametrize(("name", "off"), [("host_heartbeat", 0), ("abort_connection_option", "quick_stop")])
def test_supervision_cannot_be_taken_away_while_the_motor_runs(wire: Wire, name: str, off: int | str) -> None:
    drive = wire.session.drive
    _run_up(wire)
    with pytest.raises(SdoAbort) as refused:
        drive.write(name, off)
    assert refused.value.code == Abort.DEVICE_STATE
    drive.stop_heartbeat()
    wire.session.clock.wait(1.0)
    assert not _is_enabled(wire)


@over_both_wires
def test_what_would_switch_the_supervision_off_is_refused(wire: Wire) -> None:
    drive = wire.session.drive
    option, entry = drive.dictionary["abort_connection_option"], drive.dictionary["host_heartbeat"]
    for variable, data, code in (
        (option, b"\0\0", Abort.VALUE),
        (entry, (127 << 16 | 2001).to_bytes(4, "little"), Abort.VALUE_HIGH),
        (entry, (127 << 16 | 65535).to_bytes(4, "little"), Abort.VALUE_HIGH),
    ):
        with pytest.raises(SdoAbort) as refused:
            drive.link.download(variable.index, variable.sub, data)
        assert refused.value.code == code
    drive.write("host_heartbeat", 127 << 16 | 2000)


@over_both_wires
def test_a_watchdog_is_proven_by_silence_once(wire: Wire) -> None:
    drive = wire.session.drive
    drive._prove_watchdog = True
    drive.connect()
    drive.enable(Mode.VELOCITY)
    assert drive.number("link_losses") == 1
    drive.disable()
    drive.enable(Mode.VELOCITY)
    drive.wait(1.0)
    assert drive.number("link_losses") == 1
    assert drive.state() is State.OPERATION_ENABLED


@over_both_wires
def test_a_watchdog_that_sleeps_is_found_and_the_drive_not_enabled(wire: Wire) -> None:
    drive, clock = wire.session.drive, wire.session.clock
    drive._prove_watchdog = True
    drive.connect()
    feeding = clock.call_every(0.1, drive.link.send_heartbeat)  # another program feeds it
    with pytest.raises(CapabilityMissing, match=r"did not notice that this host was silent for 0\.6 s"):
        drive.enable(Mode.VELOCITY)
    assert drive.state() is State.SWITCH_ON_DISABLED
    feeding.cancel()


@over_both_wires
def test_nmt_stop_switches_the_power_stage_off(wire: Wire) -> None:
    _run_up(wire)
    wire.send(0x000, 0x02, NODE)
    wire.send(0x000, 0x80, NODE)
    assert not _is_enabled(wire)


@over_both_wires
def test_quick_stop_brakes_to_standstill(wire: Wire) -> None:
    _run_up(wire)
    wire.send(0x600 + NODE, 0x2B, 0x40, 0x60, 0x00, 0x02, 0x00, 0, 0)
    assert wire.session.drive.state() is State.QUICK_STOP_ACTIVE
    wire.session.clock.wait(0.2)
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED
    assert abs(wire.session.drive.number("omega_m")) < 0.5


@over_both_wires
def test_overcurrent_trips_and_is_reported_once(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    with pytest.raises(DriveFault, match="0x2310"), drive.enabled(Mode.TORQUE):
        drive.write("torque_command", 2.0)
        drive.wait(0.02)
        drive.write("i_trip", 1.0)  # the references keep below a level that was there before them
        drive.wait(0.1)
    assert drive.state() is State.FAULT
    assert len([frame for frame in wire.frames() if frame[0] == 0x080 + NODE]) == 1
    with pytest.raises(DriveFault, match="in fault: 0x2310"):
        drive.enable(Mode.TORQUE)
    drive.reset_fault()
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert drive.number("error_code") == 0
    assert drive.number("error_history_count") == 1, "an error reset is no error"
    assert drive.number("error_1") == 0x2310


def test_a_drive_that_does_not_confirm_is_stopped_by_nmt(wire: Wire) -> None:
    """The dictionary is mute (NMT stopped) when the host wants to disable: it says so, and sends NMT stop."""
    drive = wire.session.drive
    _run_up(wire)
    wire.send(0x000, 0x02, NODE)
    wire.frames()
    with pytest.raises(StateError, match="did not confirm"):
        drive.disable()
    assert (0x000, bytes([0x02, NODE])) in wire.frames()
    wire.send(0x000, 0x80, NODE)
    assert not _is_enabled(wire)


@over_both_wires
def test_a_drive_that_nmt_has_stopped_is_told_of_with_the_way_out(wire: Wire) -> None:
    drive = wire.session.drive
    drive.link.nmt(NmtCommand.STOP)
    drive.wait(1.0)
    with pytest.raises(StateError, match=r"NMT state stopped.* `benchtool reset`"):
        drive.check()
    drive.link.nmt(NmtCommand.START)
    assert drive.check().dictionary_hash == drive.dictionary.hash


def test_a_host_that_leaves_a_mute_drive_falls_silent(wire: Wire) -> None:
    """What the host cannot disable any more, the drive's own supervision stops for lack of a heartbeat."""
    _run_up(wire)
    wire.send(0x000, 0x02, NODE)
    with pytest.raises(StateError, match="heartbeat ends now"):
        wire.session.drive.__exit__(None, None, None)
    wire.frames()
    wire.session.clock.wait(1.0)
    assert [can_id for can_id, _ in wire.frames() if can_id == 0x700 + 127] == []
    wire.send(0x000, 0x80, NODE)
    assert not _is_enabled(wire)
