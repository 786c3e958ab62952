"""`[bench]` of a profile: what can be stated of sensors and clock, and what is refused."""

from __future__ import annotations

import math
from datetime import date
from pathlib import Path

import pytest

from benchtool.bench.equipment import declared
from benchtool.bench.wires.wire import FarEnd
from benchtool.errors import PlanError, ProfileError
from benchtool.plan.model import load_plan, plan_path
from benchtool.plan.validation import require_known
from benchtool.profile import Bench, Sensor, eds_path, load_bench, load_profile, profile_path
from benchtool.profile.equipment import CanSupply, Operator
from benchtool.protocol.dictionary import Dictionary

WHOLE = """
[bench.channels.i_a]
sensor = "LEM IT 60-S"
serial_number = "1234"
certificate = "2026-0815"
due = 2027-03-01
gain_U_percent = 0.5
offset_limit_A = 0.03
resolution_A = 0.001
bandwidth_Hz = 2e5

[bench.channels.omega_m]
gain_limit_percent = 0.1
offset_U_rad_s = 0.2
k = 2.5

[bench.clock]
tolerance_ppm = 50
"""

TRANSDUCER = """
[bench.transducer]
kind = "can"
dbc = "torque.dbc"
message = "Torque"
rate_Hz = 1000.0
"""


def _bench(tmp_path: Path, text: str) -> Bench:
    path = tmp_path / "bench.toml"
    path.write_text(text, encoding="utf-8")
    return load_bench(str(path))


def test_a_bench_is_read_from_a_file_of_its_own(tmp_path: Path) -> None:
    bench = _bench(tmp_path, WHOLE)
    i_a, omega_m = bench.channels["i_a"], bench.channels["omega_m"]
    assert (i_a.unit, omega_m.unit) == ("A", "rad/s")
    assert i_a.gain_standard == pytest.approx(0.0025)  # U / k
    assert i_a.offset_standard == pytest.approx(0.03 / math.sqrt(3.0))  # rectangular
    assert omega_m.gain_standard == pytest.approx(0.001 / math.sqrt(3.0))
    assert omega_m.offset_standard == pytest.approx(0.08)
    assert i_a.label == "LEM IT 60-S, no. 1234, certificate 2026-0815"
    assert bench.clock is not None
    assert bench.clock.relative_standard == pytest.approx(50e-6 / math.sqrt(3.0))


def test_a_calibration_holds_up_to_the_day_it_is_due(tmp_path: Path) -> None:
    i_a = _bench(tmp_path, WHOLE).channels["i_a"]
    assert not i_a.overdue(date(2027, 3, 1))
    assert i_a.overdue(date(2027, 3, 2))
    assert not Sensor().overdue(date(2100, 1, 1))


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("offset_U = 0.1", "'offset_U' does not end in its channel's unit, one of offset_U_A"),
        ("resolution_ohm = 0.1", "'resolution_ohm' does not end in its channel's unit"),
        ("offset_U_A = 0.1\nresolution_V = 1.0", "offset_U_A, resolution_V end in different units"),
        ("gain_U_percent = 0.1\ngain_limit_percent = 0.2", "both gain_U and gain_limit"),
        ("offset_U_A = 0.1\noffset_limit_A = 0.2", "both offset_U and offset_limit"),
        ("unit = 'A'", "leave out 'unit'"),
        ("gain_U_prcent = 0.1", "did you mean 'gain_U_percent'?"),
        ("gain_U_percent = -0.1", "greater than or equal to 0"),
        ("gain_U_percent = nan", "finite"),
        ("k = 0.0", "greater than or equal to 1"),
        ("bandwidth_Hz = 0.0", "greater than 0"),
        ("bandwidth_tolerance_percent = 5.0", "bandwidth_tolerance_percent without a bandwidth_Hz"),
        ("bandwidth_Hz = 1e3\nbandwidth_tolerance_percent = -1.0", "greater than or equal to 0"),
        ("bandwidth_Hz = 1e3\nbandwidth_tolerance_percent = nan", "finite"),
        ("bandwidth_Hz = 1e3\nbandwidth_tolerance_percent = 60", "less than or equal to 50"),
        ("due = '2027-03-01'", "a date without quotes is expected, such as 2027-03-01"),
        (
            "calibrated = 2026-03-01\ndue = 2026-02-28",
            "due on 2026-02-28, before it was calibrated on 2026-03",
        ),
    ],
)
def test_what_cannot_be_is_refused_by_its_key(tmp_path: Path, line: str, message: str) -> None:
    with pytest.raises(ProfileError) as refused:
        _bench(tmp_path, f"[bench.channels.i_a]\n{line}\n")
    assert message in str(refused.value)
    assert "bench.toml, line" in str(refused.value)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ('[bench]\nload = "person"', "key 'bench.load' is 'person': a table is expected"),
        ("[bench.channels]\ni_a = 0.2", "key 'bench.channels.i_a' is 0.2: a table is expected"),
        ("[bench]\nchannels = 3", "key 'bench.channels' is 3: a table is expected"),
        (
            f"{TRANSDUCER}signals = 'torque'",
            "key 'bench.transducer.signals' is 'torque': an array is expected",
        ),
        (f"{TRANSDUCER}signals = ['torque', 'torque']", "signal 'torque' is named twice"),
        (f"{TRANSDUCER}signals = ['torque']\ncounter = 'torque'", "signal 'torque' is named twice"),
    ],
)
def test_tables_and_arrays_are_asked_for_by_these_words(tmp_path: Path, section: str, message: str) -> None:
    with pytest.raises(ProfileError) as refused:
        _bench(tmp_path, f"{section}\n")
    assert message in str(refused.value)
    assert "bench.toml, line" in str(refused.value)


def test_an_angle_has_no_gain(tmp_path: Path) -> None:
    with pytest.raises(ProfileError, match="exact after a whole revolution"):
        _bench(tmp_path, "[bench.channels.theta_m]\ngain_U_percent = 0.1\n")
    assert _bench(tmp_path, "[bench.channels.theta_m]\noffset_limit_rad = 0.1\n").channels["theta_m"].unit


def test_a_bench_is_read_back_from_json_as_it_was_stated(tmp_path: Path) -> None:
    section = "certificate = '7'\ncalibrated = 2026-01-31\ndue = 2027-01-31\noffset_limit_A = 0.1\n"
    bench = _bench(tmp_path, f"[bench.channels.i_a]\n{section}[bench.clock]\ntolerance_ppm = 5\n")
    document = bench.model_dump_json(exclude_defaults=True)
    assert '"offset_limit_A":0.1' in document
    assert Bench.model_validate_json(document) == bench


def test_a_file_without_a_bench_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ProfileError, match=r"has no section \[bench\]"):
        _bench(tmp_path, "title = 'x'\n")


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("[bench.channels.i_A]\ngain_U_percent = 1.0", "no channel 'i_A'"),
        ("[bench.channels.i_a]\noffset_U_V = 1.0", "'i_a' is in A, its offset or resolution in V"),
        ("[bench.channels.torque_transducer]\noffset_U_A = 1.0", "'torque_transducer' is in Nm"),
        ("[bench.channels.switching_count]\noffset_U_A = 1.0", "'switching_count' has no unit, its offset"),
        ("[bench.channels.i_b]\n[bench.channels.i_A]\n", "no channel 'i_A'"),
    ],
)
def test_a_sensor_of_no_channel_is_refused_before_a_run(tmp_path: Path, section: str, message: str) -> None:
    text = profile_path("zhu2011").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(f"{text}\n{section}\n", encoding="utf-8")
    profile = load_profile(str(tmp_path / "mine.toml"))
    dictionary = Dictionary.from_eds(eds_path(profile, profile_path("zhu2011")), 1)
    name = "zhu2011/ripple"
    with pytest.raises((ProfileError, PlanError)) as refused:
        require_known(
            load_plan(name),
            plan_path(name),
            profile,
            dictionary,
            transducer=True,
            profile_file=tmp_path / "mine.toml",
        )
    assert message in str(refused.value)
    wrong = section.strip().splitlines()
    line = len(text.splitlines()) + 1 + max(at for at, each in enumerate(wrong, 1) if each.startswith("["))
    assert str(refused.value).startswith(f"{tmp_path / 'mine.toml'}, line {line}, [bench.channels]: ")


def test_the_shipped_profile_states_of_the_sensors_the_step_that_no_sample_shows() -> None:
    """The emulated sensors have no error of gain, offset or clock, so that there is nothing else to state."""
    profile = load_profile("zhu2011")
    emulator = profile.emulator
    assert emulator is not None
    step_V = emulator.sensors.u_full_scale_V / 2**emulator.sensors.adc_bits
    assert profile.bench.channels == {"u_dc": Sensor.model_validate({"resolution_V": step_V})}
    assert profile.bench.clock is None


@pytest.mark.parametrize("kind", ["operator", "person"])
def test_a_load_by_hand_has_a_present_and_a_former_name(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "bench.toml"
    path.write_text(f'[bench.load]\nkind = "{kind}"\n', encoding="utf-8")
    assert isinstance(load_bench(str(path)).load, Operator)


@pytest.mark.parametrize(
    ("bus", "complaint"),
    [
        ("can:nosuch:x", "no interface 'nosuch' of python-can: the names are"),
        ("can:scoketcan:can0", "did you mean 'socketcan'"),
        ("can:virtual", "link 'can:virtual' is not known"),
        ("can:virtual:lab?bitrat=5", "unknown option 'bitrat'"),
    ],
)
@pytest.mark.parametrize("far_end", [FarEnd.EMULATED_DRIVE, FarEnd.DRIVE])
def test_the_bus_of_an_instrument_is_checked_on_every_bench(
    far_end: FarEnd, bus: str, complaint: str
) -> None:
    supply = CanSupply(kind="can", dbc="a.dbc", message="Power", rate_Hz=50.0, u_dc="voltage", bus=bus)
    profile = load_profile("zhu2011").model_copy(update={"bench": Bench(supply=supply)})
    with pytest.raises(ProfileError, match=rf"bench\.supply\.bus .*: .*{complaint}"):
        declared(profile, far_end)
    declared(profile, FarEnd.RECORDING)
