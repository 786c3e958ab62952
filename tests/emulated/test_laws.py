"""The control laws over the wire: chosen by name while the drive is off; each of them runs the machine."""

from __future__ import annotations

import pytest

from benchtool.drive.parameters.transaction import default_of
from benchtool.emulator.control.laws import Law
from benchtool.errors import SdoAbort
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.modes import Mode

from .conftest import Wire

NAMES = [law.name.lower() for law in Law]


def test_the_dictionary_names_every_law_with_its_number(wire: Wire) -> None:
    law = wire.session.drive.dictionary["law"]
    assert [law.encode(name) for name in NAMES] == [bytes([law]) for law in Law]
    assert default_of(law) == "tpc"


@pytest.mark.parametrize("name", NAMES[1:])
def test_a_law_is_refused_while_the_power_stage_is_on(wire: Wire, name: str) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    law = drive.dictionary["law"]
    with pytest.raises(SdoAbort) as refused:
        drive.link.download(law.index, law.sub, law.encode(name))
    assert refused.value.code == Abort.DEVICE_STATE
    assert drive.read("law") == "tpc"
    drive.disable()
    drive.write("law", name)
    assert drive.read("law") == name


@pytest.mark.parametrize("name", NAMES)
def test_every_law_turns_the_machine(wire: Wire, name: str) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.write("law", name)
    drive.enable(Mode.VELOCITY)
    drive.write("omega_m_command", 30.0)
    drive.wait(1.0)
    assert drive.number("omega_m") == pytest.approx(30.0, abs=1.0)
