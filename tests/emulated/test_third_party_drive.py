"""A third-party drive on the CAN link, with the objects of CiA 301 and CiA 402 only.

The drive is the emulated one; the host only knows a third-party EDS.
"""

from __future__ import annotations

import itertools
import json
import re
import shutil
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import can
import pytest
from typer.testing import CliRunner

from benchtool.bench.session import Session, open_session
from benchtool.cli import app
from benchtool.drive.capabilities import Capability
from benchtool.drive.quantities import DC_LINK_VOLTAGE, SPEED, SPEED_SETPOINT, TORQUE, TORQUE_SETPOINT, in_si
from benchtool.errors import CapabilityMissing, ValueRefused
from benchtool.profile import load_profile
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary.roles import Role
from benchtool.protocol.modes import Mode
from benchtool.run.jog import jog
from benchtool.shipped import shipped
from tests.third_party_drives import stripped_eds

NODE = 1
RPDO = 0x200 + NODE
HOST_HEARTBEAT = 0x700 + 127
T_N_NM = 9.55

_numbers = itertools.count()

SPEED_ROLES = """
[roles]
target_velocity = { object = "0x60FF:00", unit = "rad/s", factor = 0.001 }
velocity_actual = { object = "0x606C", unit = "rad/s", factor = 0.001 }
"""


def third_party_profile(
    folder: Path, roles: str = SPEED_ROLES, drive: str = "", without: Collection[str] = ()
) -> Path:
    """The paper's machine on a drive with a third-party EDS."""
    (folder / "vendor.eds").write_bytes(stripped_eds(without=without))
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    text = text.partition("# Where the paper")[0].replace('eds = "drive.eds"', f'eds = "vendor.eds"\n{drive}')
    path = folder / "profile.toml"
    path.write_text(f"{text}\n{roles}", encoding="utf-8")
    return path


class Bench:
    """A session with such a drive, and what has been on its bus."""

    def __init__(self, session: Session, bus: can.BusABC) -> None:
        self.session = session
        self.drive = session.drive
        self._bus = bus

    def frames(self) -> list[tuple[int, bytes]]:
        self.session.clock.wait(0.0)
        seen = []
        while (frame := self._bus.recv(0)) is not None:
            seen.append((frame.arbitration_id, bytes(frame.data)))
        return seen


Opener = Callable[..., Bench]


@pytest.fixture
def open_third_party(tmp_path: Path) -> Iterator[Opener]:
    with ExitStack() as stack:

        def opener(**options: Any) -> Bench:
            channel = f"foreign-{next(_numbers)}"
            bus = stack.enter_context(can.Bus(interface="virtual", channel=channel))
            path = third_party_profile(tmp_path, **options)
            session = stack.enter_context(open_session(str(path), f"emulated?channel={channel}"))
            return Bench(session, bus)

        yield opener


def test_it_is_armed_enabled_and_driven_by_standard_objects(open_third_party: Opener) -> None:
    bench = open_third_party()
    drive = bench.drive
    assert "torque_command" not in drive.dictionary
    drive.connect()
    assert drive.number(Role.CONSUMER_HEARTBEAT) == 127 << 16 | 500
    with drive.enabled(Mode.VELOCITY):
        drive.write(in_si(drive, SPEED_SETPOINT), 15.0)
        drive.wait(0.5)
        assert drive.number(in_si(drive, SPEED)) == pytest.approx(15.0, abs=0.3)
        assert drive.number(in_si(drive, DC_LINK_VOLTAGE)) == pytest.approx(122.5, rel=0.02)
    assert drive.state() is State.SWITCH_ON_DISABLED
    with drive.enabled(Mode.TORQUE):
        drive.write(in_si(drive, TORQUE_SETPOINT), 0.5)
        assert drive.number(Role.TARGET_TORQUE) == round(0.5 / T_N_NM * 1000.0)
        drive.wait(0.1)
        assert drive.number(in_si(drive, TORQUE)) == pytest.approx(0.5, abs=0.1)
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert drive.number(Role.TARGET_TORQUE) == drive.number(Role.TARGET_VELOCITY) == 0
    sent = [can_id for can_id, _ in bench.frames()]
    assert HOST_HEARTBEAT in sent


def test_its_host_that_falls_silent_stops_it(open_third_party: Opener) -> None:
    drive = open_third_party().drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    drive.wait(1.0)
    assert drive.state() is State.OPERATION_ENABLED
    drive.stop_heartbeat()
    drive.clock.wait(0.8)
    assert drive.state() is State.FAULT


@pytest.mark.parametrize(("mode", "value"), [(Mode.VELOCITY, 15.0), (Mode.TORQUE, 0.4)])
def test_jog_moves_it_by_frames_of_its_own_target(open_third_party: Opener, mode: Mode, value: float) -> None:
    bench = open_third_party()
    bench.drive.connect()
    bench.frames()
    motor = bench.session.profile.motor
    duration_s = 0.4 if mode is Mode.VELOCITY else 0.1
    result = jog(bench.drive, motor, mode, lambda _: value, duration_s=duration_s, rate_Hz=200.0)
    reached = result.omega_m_rad_s if mode is Mode.VELOCITY else result.torque_Nm
    assert reached == pytest.approx(value, abs=0.3 if mode is Mode.VELOCITY else 0.1)
    frames = [data for can_id, data in bench.frames() if can_id == RPDO]
    size, raw = (4, 15_000) if mode is Mode.VELOCITY else (2, round(value / T_N_NM * 1000.0))
    assert frames == [raw.to_bytes(size, "little")] * round(duration_s * 200.0)
    assert bench.drive.state() is State.SWITCH_ON_DISABLED
    assert int(bench.drive.number(Role.RPDO_COB_ID)) >> 31, "the frame is out of use again"


def test_a_speed_in_units_of_the_user_is_not_guessed(open_third_party: Opener) -> None:
    bench = open_third_party(roles="")
    drive = bench.drive
    drive.connect()
    bench.frames()
    with pytest.raises(CapabilityMissing, match=r"units of its own; .* \[roles\] target_velocity = "):
        jog(drive, bench.session.profile.motor, Mode.VELOCITY, lambda _: 1.0, duration_s=0.1)
    result = jog(drive, bench.session.profile.motor, Mode.TORQUE, lambda _: 0.3, duration_s=0.1)
    assert result.torque_Nm == pytest.approx(0.3, abs=0.1)
    assert result.omega_m_rad_s is None


@pytest.mark.parametrize(
    ("without", "said"),
    [
        (["6071"], r"no 'torque': .* vendor\.eds has not 0x6071:0 target_torque"),
        (["6076"], r"has it in per mille, and no 0x6076:0 motor_rated_torque"),
        (["1400"], r"setpoints at a rate take RPDO1, and .*vendor\.eds has no 0x1400:1 rpdo_cob_id"),
    ],
)
def test_a_torque_that_it_has_not_is_refused(open_third_party: Opener, without: list[str], said: str) -> None:
    bench = open_third_party(without=without)
    bench.drive.connect()
    with pytest.raises((CapabilityMissing, ValueRefused), match=said):
        jog(bench.drive, bench.session.profile.motor, Mode.TORQUE, lambda _: 0.1, duration_s=0.1)
    assert bench.drive.state() is State.SWITCH_ON_DISABLED


def test_a_profile_says_what_a_raw_step_of_torque_is(open_third_party: Opener) -> None:
    roles = f'[roles]\ntarget_torque = {{ object = "0x6071", unit = "mNm", factor = {T_N_NM} }}\n'
    drive = open_third_party(roles=roles, without=["6076"]).drive
    drive.connect()
    drive.write(in_si(drive, TORQUE_SETPOINT), 1.91)
    assert drive.link.upload(0x6071, 0) == (200).to_bytes(2, "little")


def test_a_profiles_redirection_goes_before_benchtools_own_object(tmp_path: Path) -> None:
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    path = tmp_path / "profile.toml"
    path.write_text(f'{text}\n[roles]\ntarget_torque = "0x6071"\n', encoding="utf-8")
    with open_session(str(path)) as session:
        session.drive.connect()
        assert in_si(session.drive, SPEED_SETPOINT).name == "omega_m_command"
        setpoint = in_si(session.drive, TORQUE_SETPOINT)
        assert (setpoint.key, setpoint.unit) == ((0x6071, 0), "Nm")
        assert setpoint.factor == pytest.approx(T_N_NM / 1000.0)


@pytest.mark.parametrize("allowed", [False, True])
def test_a_drive_without_supervision_runs_only_if_the_profile_says_so(
    open_third_party: Opener, allowed: bool
) -> None:
    bench = open_third_party(without=["1016"], drive="allow_unsupervised = true\n" if allowed else "")
    drive = bench.drive
    if not allowed:
        with pytest.raises(CapabilityMissing, match="no 'supervised': the motor would run on"):
            drive.connect()
        with pytest.raises(CapabilityMissing, match="no 'supervised'"):
            drive.enable(Mode.TORQUE)
        assert HOST_HEARTBEAT not in [can_id for can_id, _ in bench.frames()]
        return
    drive.connect()
    with drive.enabled(Mode.TORQUE):
        assert drive.state() is State.OPERATION_ENABLED
    stated = drive.supervision.to_json()
    assert stated["armed"] is False
    assert "0x1016:1 consumer_heartbeat" in str(stated["reason"])


# ---- the command line ----------------------------------------------------------------------------------


def _invoked(*arguments: str | Path) -> Any:
    return CliRunner().invoke(app, [str(each) for each in arguments])


@pytest.mark.parametrize("without", [(), ("6041",), ("6040", "6060", "1018", "1016")])
def test_info_shows_what_there_is(tmp_path: Path, without: Collection[str]) -> None:
    path = third_party_profile(tmp_path, without=without)
    told = _invoked("info", "--profile", path, "--json")
    assert told.exit_code == 0, told.stderr
    document = json.loads(told.stdout)
    assert document["capabilities"]["capture"]["available"] is False
    assert document["capabilities"]["torque"]["available"] is (not without)
    assert document["state"] == (None if "6041" in without else "switch on disabled")
    assert document["dictionary_hash"] is None
    assert "no" in _invoked("info", "--profile", path).stdout


def test_info_of_a_file_asks_no_drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    eds = tmp_path / "vendor.eds"
    eds.write_bytes(stripped_eds(without=["6071"]))
    monkeypatch.setattr("benchtool.bench.session.open_session", None)
    told = _invoked("info", "--eds", eds, "--json")
    assert told.exit_code == 0, told.stderr
    document = json.loads(told.stdout)
    assert list(document["capabilities"]) == [str(each) for each in Capability]
    assert document["capabilities"]["torque"] == {
        "available": False,
        "by": [],
        "missing": ["0x6071:0 target_torque"],
    }
    assert document["capabilities"]["supervised"]["available"] is True
    assert document["vendor_name"] == "Müller Größenantriebe"
    shown = _invoked("info", "--eds", eds).stdout
    assert "ripple and spectra cannot be measured" in " ".join(shown.split()).replace(" │ │ │ ", " ")


def test_info_refuses_a_file_that_is_not_an_eds(tmp_path: Path) -> None:
    (tmp_path / "no.eds").write_text("nothing\n", encoding="utf-8")
    told = _invoked("info", "--eds", tmp_path / "no.eds")
    assert told.exit_code == 2
    assert _invoked("info", "--eds", tmp_path / "no.eds", "--link", "can:virtual:x").exit_code == 2
    assert "an EDS or DCF (CiA 306) is expected" in told.stderr


@pytest.mark.parametrize(
    ("arguments", "capability"),
    [
        (["record", "--duration", "1"], "stream"),
        (["run", "zhu2011/ripple"], "capture"),
        (["jog", "--duration", "1", "--torque", "0.1"], "torque"),
        (["params", "save"], "storage"),
    ],
)
def test_each_verb_says_what_it_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], capability: str
) -> None:
    monkeypatch.chdir(tmp_path)
    lacking = {"torque": ["6071"], "storage": ["1010"]}
    path = third_party_profile(tmp_path, without=lacking.get(capability, []))
    told = _invoked(*arguments, "--profile", path)
    assert told.exit_code == 2, told.stderr
    assert f"no '{capability}'" in told.stderr
    assert "nothing was sent" in told.stderr
    assert not [each for each in tmp_path.iterdir() if each.suffix not in (".toml", ".eds")]


@pytest.mark.parametrize("without", [(), ("603F",)])
def test_reset_takes_the_error_code_by_its_role(tmp_path: Path, without: Collection[str]) -> None:
    told = _invoked("reset", "--profile", third_party_profile(tmp_path, without=without), "--json")
    assert told.exit_code == 0, told.stderr
    assert json.loads(told.stdout)["error_code"] == (None if without else "0x0000")


def test_jog_tells_that_nothing_watches_it(tmp_path: Path) -> None:
    path = third_party_profile(tmp_path, without=["1016"], drive="allow_unsupervised = true\n")
    told = _invoked("jog", "--torque", "0.1", "--duration", "0.05", "--profile", path, "--json")
    assert told.exit_code == 0, told.stderr
    assert json.loads(told.stdout)["supervision"]["armed"] is False
    assert "without link supervision, as the profile allows" in told.stderr


def test_the_profile_as_a_whole_is_read(tmp_path: Path) -> None:
    profile = load_profile(str(third_party_profile(tmp_path, drive="allow_unsupervised = true\n")))
    assert profile.drive.allow_unsupervised
    assert set(profile.roles) == {"target_velocity", "velocity_actual"}


# ---- what a run says of its supervision ------------------------------------------------------------------


def _plan_without_supervision(folder: Path, drive: str) -> Path:
    """Plan of a short run with benchtool's drive, whose EDS lacks 0x1016."""
    eds = (shipped("firmware_protocol") / "drive.eds").read_text(encoding="utf-8")
    eds = "\n".join(each for each in re.split(r"\n(?=\[)", eds) if not each.startswith("[1016"))
    (folder / "own.eds").write_text(eds, encoding="utf-8")
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    profile = folder / "profile.toml"
    profile.write_text(text.replace('"drive.eds"', f'"own.eds"\n{drive}'), encoding="utf-8")
    plan = folder / "plan.toml"
    plan.write_text(
        f'title = "Short"\nprofile = "{profile}"\n[operating_point]\nmode = "torque"\ntorque_Nm = 0.2\n'
        f'hold_speed_rad_s = 10.0\nsettle_s = 0.1\n[record]\nduration_s = 0.02\nchannels = ["torque"]\n'
        f"[analyses]\nsteady = false\n",
        encoding="utf-8",
    )
    return plan


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("drive", ["", "allow_unsupervised = true"])
def test_manifest_and_reports_say_that_a_drive_ran_unsupervised(tmp_path: Path, drive: str) -> None:
    plan = _plan_without_supervision(tmp_path, drive)
    ran = _invoked("run", plan, "--out", tmp_path / "a")
    if not drive:
        assert ran.exit_code == 2
        assert "no 'supervised': the motor would run on" in ran.stderr
        return
    assert ran.exit_code in (0, 1), ran.stderr
    manifest = json.loads((tmp_path / "a" / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["details"]["supervision"]["armed"] is False
    assert "without link supervision, as the profile allows: no 'supervised'" in ran.stderr
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    _invoked("report", tmp_path / "a")
    _invoked("compare", tmp_path / "a", tmp_path / "b", "--html", tmp_path / "c.html")
    for page in (tmp_path / "a" / "report.html", tmp_path / "c.html"):
        said = "The drive ran without link supervision, as the profile allows"
        assert said in page.read_text(encoding="utf-8")
