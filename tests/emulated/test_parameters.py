"""Parameters of the emulated drive: written all or none after any failure; storing and restoring."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from benchtool.drive import RemoteDrive
from benchtool.drive.parameters.storage import reset, restore_defaults, store
from benchtool.drive.parameters.transaction import default_of, parameters, snapshot, write_all
from benchtool.errors import NoAnswer, SdoAbort, ValueRefused, WriteNotVerified
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.dictionary.variable import Value
from benchtool.protocol.modes import Mode

from .conftest import Wire, over_both_wires

NODE = 1
Sabotage = Callable[[RemoteDrive], None]


def _at_write(monkeypatch: pytest.MonkeyPatch, drive: RemoteDrive, number: int, then: Sabotage) -> None:
    """Have `then` happen just ahead of the `number`-th write from now."""
    download = drive.link.download
    writes = iter(range(1, 1000))

    def sabotaged(index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        if next(writes) == number:
            then(drive)
        download(index, sub, data, block=block)

    monkeypatch.setattr(drive.link, "download", sabotaged)


def _enable(drive: RemoteDrive) -> None:
    drive.enable(Mode.TORQUE)


def _requests(wire: Wire) -> list[bytes]:
    return [data for can_id, data in wire.frames() if can_id == 0x600 + NODE]


def _downloads(wire: Wire) -> list[bytes]:
    return [data for data in _requests(wire) if data[0] >> 5 == 1]


def _notes(error: BaseException) -> str:
    return "; ".join(getattr(error, "__notes__", ()))


# ---- all or none -------------------------------------------------------------------------------------------


def test_several_are_written_and_the_old_values_are_told(wire: Wire) -> None:
    drive = wire.session.drive
    assert write_all(drive, {"R_s": 0.2, "pole_pairs": 5}) == {"R_s": 0.123, "pole_pairs": 4}
    assert (drive.read("R_s"), drive.read("pole_pairs")) == (0.2, 5)


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"R_s": 0.2, "u_s": 1e6}, "its limits are 0 to 1000 V"),
        ({"R_s": 0.2, "law": "tcp"}, "law = 'tcp'"),
        ({"R_s": 0.2, "nonsense": 1}, "no object 'nonsense'"),
        ({"R_s": 0.2, "statusword": 1}, "'statusword' (0x6041:0) is a status"),
        ({"R_s": 0.2, "torque_command": 1.0}, "'torque_command' (0x2020:1) is a command"),
    ],
)
def test_one_wrong_value_and_nothing_is_sent(wire: Wire, values: dict[str, Value], complaint: str) -> None:
    wire.frames()
    with pytest.raises(ValueRefused) as refused:
        write_all(wire.session.drive, values)
    assert complaint in str(refused.value)
    assert _downloads(wire) == []


@over_both_wires
def test_what_needs_the_power_stage_off_is_refused_before_anything_is_sent(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    wire.frames()
    with pytest.raises(
        ValueRefused, match="'operation enabled', pole_pairs can be set with the power stage off"
    ):
        write_all(drive, {"R_s": 0.2, "pole_pairs": 5})
    assert _downloads(wire) == []
    write_all(drive, {"R_s": 0.2})
    assert drive.read("R_s") == 0.2


def test_a_refusal_half_way_restores_what_was_written(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another master enables the drive between two writes: the third value is then refused for its state."""
    drive = wire.session.drive
    before = snapshot(drive)
    _at_write(monkeypatch, drive, 3, _enable)
    with pytest.raises(SdoAbort) as refused:
        write_all(drive, {"R_s": 0.2, "u_s": 60.0, "pole_pairs": 5, "i_trip": 9.0})
    assert refused.value.code == Abort.DEVICE_STATE
    assert _notes(refused.value) == "the old values are in force again"
    assert snapshot(drive) == before


def test_what_cannot_be_restored_is_named_and_the_rest_is_restored(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = wire.session.drive
    before = snapshot(drive)
    _at_write(monkeypatch, drive, 3, _enable)
    with pytest.raises(SdoAbort) as refused:
        write_all(drive, {"R_s": 0.2, "encoder_lines": 1000, "pole_pairs": 5})
    assert "the old value of encoder_lines (2500) could not be restored" in _notes(refused.value)
    assert snapshot(drive) == {**before, "encoder_lines": 1000}


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, SystemExit])
def test_any_exception_restores(
    wire: Wire, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    drive = wire.session.drive
    before = snapshot(drive)

    def fail(_: RemoteDrive) -> None:
        raise error

    _at_write(monkeypatch, drive, 3, fail)
    with pytest.raises(error) as raised:
        write_all(drive, {"R_s": 0.2, "u_s": 60.0, "i_trip": 9.0})
    assert _notes(raised.value) == "the old values are in force again"
    assert snapshot(drive) == before


def test_a_write_that_did_not_hold_restores(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = wire.session.drive
    before = snapshot(drive)
    variable = drive.dictionary["u_s"]
    upload = drive.link.upload
    lies = iter([variable.encode(7.0)])

    def meddled(index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        data = upload(index, sub, block=block, length=length)
        return next(lies, data) if data == variable.encode(60.0) else data

    monkeypatch.setattr(drive.link, "upload", meddled)
    with pytest.raises(WriteNotVerified, match="'u_s' reads back"):
        write_all(drive, {"R_s": 0.2, "u_s": 60.0})
    assert snapshot(drive) == before


@over_both_wires
def test_a_link_that_died_is_not_asked_once_for_every_value(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = wire.session.drive
    asked = []

    def dead(index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        asked.append(index)
        raise NoAnswer("no answer")

    def cut(_: RemoteDrive) -> None:
        monkeypatch.setattr(drive.link, "upload", dead)
        raise NoAnswer("no answer")

    _at_write(monkeypatch, drive, 3, cut)
    with pytest.raises(NoAnswer) as raised:
        write_all(drive, {"R_s": 0.2, "u_s": 60.0, "i_trip": 9.0})
    assert "i_trip (12.0), u_s (81.65), R_s (0.123) could not be restored" in _notes(raised.value)
    assert len(asked) == 1


# ---- storing and defaults ----------------------------------------------------------------------------


@over_both_wires
def test_what_is_stored_survives_a_reset_and_nothing_else_does(wire: Wire) -> None:
    drive = wire.session.drive
    write_all(drive, {"R_s": 0.5})
    store(drive)
    write_all(drive, {"R_s": 0.7, "u_s": 60.0})
    reset(drive)
    assert (drive.read("R_s"), drive.read("u_s")) == (0.5, 81.65)


@over_both_wires
def test_defaults_come_into_force_with_the_reset_and_stay(wire: Wire) -> None:
    drive = wire.session.drive
    write_all(drive, {"R_s": 0.5})
    store(drive)
    restored = restore_defaults(drive)
    defaults = {each.name: default_of(each) for each in parameters(drive.dictionary)}
    defaults["i2t_current"] = drive.number("i_full_scale")  # cut to it
    assert restored == defaults
    assert drive.read("R_s") == 0.1
    reset(drive)
    assert drive.read("R_s") == 0.1


def test_restoring_waits_for_the_next_reset(wire: Wire) -> None:
    """CiA 301, 7.5.2.14: the defaults are valid after the reset, not before it."""
    drive = wire.session.drive
    drive.link.download(0x1011, 1, b"load")
    assert drive.read("R_s") == 0.123
    reset(drive)
    assert drive.read("R_s") == 0.1


@pytest.mark.parametrize("action", [store, restore_defaults])
def test_neither_happens_while_the_motor_may_turn(
    wire: Wire, action: Callable[[RemoteDrive], object]
) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    wire.frames()
    with pytest.raises(ValueRefused, match="power stage off only: disable it first"):
        action(drive)
    assert _downloads(wire) == []


def test_a_wrong_signature_stores_nothing(wire: Wire) -> None:
    drive = wire.session.drive
    write_all(drive, {"R_s": 0.5})
    with pytest.raises(SdoAbort) as refused:
        drive.link.download(0x1010, 1, b"evas")
    assert refused.value.code == Abort.NOT_STORED
    reset(drive)
    assert drive.read("R_s") == 0.123


@pytest.mark.parametrize("action", [store, restore_defaults])
def test_a_drive_that_does_neither_on_command_is_told_apart(
    wire: Wire, monkeypatch: pytest.MonkeyPatch, action: Callable[[RemoteDrive], object]
) -> None:
    drive = wire.session.drive
    upload = drive.link.upload

    def unable(index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        return bytes(4) if index in (0x1010, 0x1011) else upload(index, sub, block=block, length=length)

    monkeypatch.setattr(drive.link, "upload", unable)
    wire.frames()
    with pytest.raises(WriteNotVerified, match="bit 0 is expected"):
        action(drive)
    assert _downloads(wire) == []


def test_a_drive_that_does_not_come_back_is_an_error(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = wire.session.drive
    nmt = drive.link.nmt
    monkeypatch.setattr(drive.link, "nmt", lambda command: nmt(NmtCommand.ENTER_PRE_OPERATIONAL))
    with pytest.raises(NoAnswer, match="no boot-up message of node 1"):
        reset(drive)


def test_a_default_that_is_not_in_force_is_named(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = wire.session.drive
    upload = drive.link.upload

    def stubborn(index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        kept = drive.dictionary["R_s"]
        return (
            kept.encode(0.5) if (index, sub) == kept.key else upload(index, sub, block=block, length=length)
        )

    monkeypatch.setattr(drive.link, "upload", stubborn)
    with pytest.raises(WriteNotVerified, match="after the reset R_s differ from their defaults"):
        restore_defaults(drive)
