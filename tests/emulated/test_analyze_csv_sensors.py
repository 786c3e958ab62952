"""The sensors behind the columns of a table, and the report of a bundle made of one."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app
from benchtool.results import verify_run
from tests.at_length import at_length
from tests.emulated.analyze_csv import Invoke, analyze, measured
from tests.emulated.csv_tables import phase_current, sinusoid, write

BENCH = """
[bench.channels."CH1 [A]"]
sensor = "current probe"
serial_number = "C-3"
certificate = "2026-1"
due = 2000-01-01
gain_U_percent = 0.5
offset_limit_A = 0.02
"""


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    time_s, current = phase_current()
    current = current + 1e-3 * np.random.default_rng(0).standard_normal(len(current))
    write("scope.csv", "t,CH1 [A]", [time_s, current])
    return analyze


def _report(folder: str) -> Result:
    result = CliRunner().invoke(app, ["report", folder])
    assert result.exit_code == 0, result.output
    return result


SCOPE = ("--csv", "scope.csv", "--time", "t", "--current", "CH1")


@pytest.mark.parametrize("key", ['"CH1 [A]"', "current", *at_length("CH1", "i_a")])
def test_a_probe_counts_by_its_column_or_by_what_it_is(invoke: Invoke, key: str) -> None:
    Path("bench.toml").write_text(BENCH.replace('"CH1 [A]"', key), encoding="utf-8")
    without = measured(invoke(*SCOPE, "--json"))["measurements"]["current_fundamental"]
    stated = measured(invoke(*SCOPE, "--bench", "bench.toml", "--json"))["measurements"]
    assert without["uncertainty"]["standard"] < 1e-3
    assert without["basis"]["sensors"] == "the sensors' own uncertainty is not stated"
    amplitude = stated["current_fundamental"]
    assert amplitude["uncertainty"]["standard"] == pytest.approx(3.0 * 0.0025, rel=0.01)
    (line,) = [each for each in amplitude["uncertainty"]["budget"] if "instrument" in each]
    assert line["name"] == "gain of CH1 [A] (current probe, no. C-3, certificate 2026-1); U = 0.5 %, k = 2"
    assert "sensors" not in amplitude["basis"]
    assert stated["current_thd_f"]["uncertainty"]["standard"] < 0.01


def test_a_ripple_of_a_table_knows_gain_and_offset_of_its_column(invoke: Invoke) -> None:
    time_s, _, angle = sinusoid(50.0)
    torque = 1.0 + 0.1 * np.cos(24.0 * angle) + 1e-4 * np.random.default_rng(1).standard_normal(len(time_s))
    write("x.csv", "t,T,phi", [time_s, torque, angle])
    Path("bench.toml").write_text(
        "[bench.channels.T]\ngain_limit_percent = 3.0\noffset_U_Nm = 0.1\n", encoding="utf-8"
    )
    turning = ("--angle", "phi", "--pole-pairs", "4")
    found = measured(
        invoke("--csv", "x.csv", "--time", "t", "--torque", "T", *turning, "--bench", "bench.toml", "--json")
    )["measurements"]
    gain, offset = 0.03 / math.sqrt(3.0), 0.05
    assert found["torque_mean"]["uncertainty"]["standard"] == pytest.approx(
        math.hypot(gain, offset), rel=0.01
    )
    assert found["torque_ripple_rms"]["uncertainty"]["standard"] == pytest.approx(
        gain * found["torque_ripple_rms"]["value"], rel=0.05
    )
    assert found["torque_order_24"]["uncertainty"]["standard"] == pytest.approx(0.1 * gain, rel=0.05)


@pytest.mark.parametrize(
    ("bench", "message"),
    [
        ("[bench.channels.u_dc]\ngain_U_percent = 1.0", "states u_dc, none of which is a column"),
        ("[bench.channels.CH2]\ngain_U_percent = 1.0", "CH2]: no column of scope.csv and no channel of a"),
        (
            "[bench.channels.current]\nbandwidth_Hz = 1e5\n[bench.channels.curent]\ngain_U_percent = 1.0",
            "curent]: no column of scope.csv and no channel of a drive: did you mean 'current'?",
        ),
        ("[bench.channels.current]\noffset_U_V = 1.0", "'CH1 [A]' is in A, its offset or resolution in V"),
        (
            "[bench.channels.current]\nbandwidth_Hz = 1e5\n[bench.channels.u_dc]\noffset_U_A = 1.0",
            "'u_dc' is in V, its offset or resolution in A",
        ),
        (
            "[bench.channels.CH1]\ngain_U_percent = 1.0\n[bench.channels.current]\ngain_U_percent = 2.0",
            "'CH1' is stated too, which is the same column: leave one out",
        ),
        ("title = 'none'", "has no section [bench]"),
    ],
)
def test_a_bench_of_other_columns_is_refused(invoke: Invoke, bench: str, message: str) -> None:
    Path("bench.toml").write_text(bench, encoding="utf-8")
    result = invoke(*SCOPE, "--bench", "bench.toml")
    assert result.exit_code != 0
    assert message in result.stderr


def test_a_gain_of_an_angle_is_refused_and_other_channels_of_a_drive_are_not(invoke: Invoke) -> None:
    """As a profile refuses it; what a profile states of channels that the table does not have stays."""
    time_s, current, angle = sinusoid(50.0)
    write("x.csv", "t,CH1 [A],phi,CH2", [time_s, current, angle, current])
    columns = ("--csv", "x.csv", "--time", "t", "--current", "CH1", "--angle", "phi", "--bench", "bench.toml")
    Path("bench.toml").write_text("[bench.channels.angle]\ngain_U_percent = 1.0\n", encoding="utf-8")
    refused = invoke(*columns)
    assert refused.exit_code != 0
    assert "'phi' has an uncertainty of its gain, and an angle is exact after a whole" in refused.stderr
    others = "".join(f"[bench.channels.{name}]\ngain_U_percent = 1.0\n" for name in ("CH1", "CH2", "u_dc"))
    Path("bench.toml").write_text(others, encoding="utf-8")
    assert invoke(*columns).exit_code == 0


def test_the_day_of_a_table_is_that_of_its_file_or_the_one_stated(invoke: Invoke) -> None:
    Path("bench.toml").write_text(BENCH, encoding="utf-8")
    assert "was due on 2000-01-01" in invoke(*SCOPE, "--bench", "bench.toml").output
    assert "due" not in invoke(*SCOPE, "--bench", "bench.toml", "--date", "1999-12-31").output


def test_the_report_of_a_bundle_shows_what_the_table_measured(invoke: Invoke) -> None:
    Path("bench.toml").write_text(BENCH, encoding="utf-8")
    result = invoke(*SCOPE, "--bench", "bench.toml", "--out", "kept", "--report")
    assert result.exit_code == 0, result.output
    first = Path("kept/report.html").read_bytes()
    _report("kept")
    assert Path("kept/report.html").read_bytes() == first  # the same page again, from the bundle alone
    again = CliRunner().invoke(app, ["analyze", "kept"])
    assert "was due on 2000-01-01" in again.output
    page = first.decode("utf-8")
    for text in ("current_fundamental", "current_harmonics", "gain of CH1 [A] (current probe", "scope.csv"):
        assert text in page


def test_bundles_of_tables_are_analysed_and_compared_as_they_were_measured(invoke: Invoke) -> None:
    """The second current is a tenth less: so are the amplitudes, and the distortion is the same."""
    time_s, current = phase_current()
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(current))
    write("weak.csv", "t,CH1 [A]", [time_s, 0.9 * current + noise])
    first = measured(invoke(*SCOPE, "--out", "first", "--json"))
    assert invoke("--csv", "weak.csv", *SCOPE[2:], "--out", "second", "--json").exit_code == 0
    again = CliRunner().invoke(app, ["analyze", "first", "--json"])
    assert again.exit_code == 0, again.output
    (case,) = json.loads(again.stdout)["cases"].values()
    assert case["measurements"] == first["measurements"]
    assert case["source"]["stream"] == "table"
    compared = CliRunner().invoke(app, ["compare", "first", "second", "--json"])
    assert compared.exit_code == 0, compared.output
    (deltas,) = json.loads(compared.stdout)["deltas"].values()
    amplitude, thd = (deltas["measurements"][f"current_{name}"] for name in ("fundamental", "thd_f"))
    assert amplitude["percent"] == pytest.approx(-10.0, abs=0.1)
    assert amplitude["exceeds_uncertainty"] is True
    assert abs(thd["absolute"]) < 0.1


def test_the_numbers_of_a_bundle_of_a_table_are_measured_again_to_the_bit(invoke: Invoke) -> None:
    """Rows that are missing, or that have no even time, are kept as they were, and so are the sensors."""
    Path("bench.toml").write_text(f"{BENCH}[bench.clock]\ntolerance_ppm = 50.0\n", encoding="utf-8")
    time_s, current, angle = sinusoid(50.0)
    current = current + 1e-3 * np.random.default_rng(0).standard_normal(len(current))
    there = np.delete(np.arange(len(time_s)), [100, 2000])
    uneven = time_s + 2e-5 * np.random.default_rng(1).random(len(time_s))
    rows = {
        "gaps": [time_s[there], current[there], angle[there]],
        "uneven": [uneven, current, angle],
    }
    for name, columns in rows.items():
        write(f"{name}.csv", "t,CH1 [A],phi", columns)
        turning = ("--angle", "phi", "--pole-pairs", "4", "--bench", "bench.toml", "--out", name)
        assert invoke("--csv", f"{name}.csv", *SCOPE[2:], *turning).exit_code == 0
        found = verify_run(Path(name))
        assert found.holds
        assert found.recomputed > 5
        assert not found.not_recomputed


def test_compare_tells_that_sensors_and_gains_of_tables_differ(invoke: Invoke) -> None:
    Path("bench.toml").write_text(BENCH, encoding="utf-8")
    invoke(*SCOPE, "--out", "bare")
    invoke(*SCOPE[:-1], "CH1:A*10", "--bench", "bench.toml", "--out", "sensed")
    compared = CliRunner().invoke(app, ["compare", "bare", "sensed", "--json"])
    (circumstances,) = json.loads(compared.stdout)["circumstances"].values()
    assert circumstances["differing"]["profile"] == {
        "bench.channels.CH1 [A].sensor": [None, "current probe"],
        "bench.channels.CH1 [A].serial_number": [None, "C-3"],
        "bench.channels.CH1 [A].certificate": [None, "2026-1"],
        "bench.channels.CH1 [A].due": [None, "2000-01-01"],
        "bench.channels.CH1 [A].gain_U_percent": [None, 0.5],
        "bench.channels.CH1 [A].offset_limit_A": [None, 0.02],
    }
    assert circumstances["differing"]["recorded rows"] == {"columns.current.gain": [1.0, 10.0]}


def test_what_a_probe_took_off_the_distortion_is_corrected(invoke: Invoke) -> None:
    """A seventh of 10 % at 350 Hz and a thirteenth of 5 % at 650 Hz, behind a probe of 600 Hz."""
    time_s = np.arange(10_000) / 10e3
    true = {50.0: 3.0, 350.0: 0.3, 650.0: 0.15}
    read = sum(
        np.real(a / (1.0 + 1j * f / 600.0) * np.exp(2j * math.pi * f * time_s)) for f, a in true.items()
    )
    write("slow.csv", "t,CH1 [A]", [time_s, read + 1e-4 * np.random.default_rng(2).standard_normal(10_000)])
    columns = ("--csv", "slow.csv", "--time", "t", "--current", "CH1", "--bench", "bench.toml")
    of_truth = 100.0 * math.hypot(0.3, 0.15) / 3.0
    guarantee = "[bench.channels.current]\nbandwidth_Hz = 600\n"
    for known in (False, True):
        text = f"{guarantee}bandwidth_tolerance_percent = 5\n" if known else guarantee
        Path("bench.toml").write_text(text, encoding="utf-8")
        case = measured(invoke(*columns, "--json"))
        thd = case["measurements"]["current_thd_f"]
        # read are 100 sqrt((0.1 / 1.158)^2 + (0.05 / 1.474)^2) x 1.0035 = 9.30 %, of 11.18 %
        assert thd["value"] - thd["correction"]["added"] == pytest.approx(9.30, abs=0.02)
        assert thd["value"] == pytest.approx(of_truth if known else 0.5 * (9.30 + of_truth), abs=0.05)
        assert thd["uncertainty"]["standard"] == pytest.approx(0.10 if known else 0.94, rel=0.1)
        harmonics = case["tables"]["current_harmonics"]
        seventh = dict(
            zip((each["name"] for each in harmonics["columns"]), harmonics["rows"][6], strict=True)
        )
        assert seventh["amplitude"] - seventh["correction"] == pytest.approx(0.3 / 1.158, rel=1e-3)
        assert abs(seventh["amplitude"] - 0.3) < 2.0 * seventh["uncertainty"]


@pytest.mark.parametrize(("day", "is_later"), [("2026-03-01", True), ("2026-04-01", False)])
def test_a_calibration_after_the_record_is_told(invoke: Invoke, day: str, is_later: bool) -> None:
    bench = BENCH.replace("due = 2000-01-01", "calibrated = 2026-04-01")
    Path("bench.toml").write_text(bench, encoding="utf-8")
    remarks = measured(invoke(*SCOPE, "--bench", "bench.toml", "--date", day, "--json"))["remarks"]
    later = [each["text"] for each in remarks if each["kind"] == "calibrated_later"]
    assert ["was calibrated on 2026-04-01, after this record of 2026-03-01" in text for text in later] == (
        [True] if is_later else []
    )


def test_three_phase_currents_have_symmetrical_components(invoke: Invoke) -> None:
    """A negative sequence of 2 % and a zero sequence of 1 % of the positive one."""
    time_s, random = np.arange(4_000) / 10_000, np.random.default_rng(4)
    columns = []
    for phase in range(3):
        angle, turn = 2.0 * np.pi * 50.0 * time_s, 2.0 * np.pi * phase / 3.0
        wave = 5.0 * np.cos(angle - turn) + 0.1 * np.cos(angle + turn + 0.4) + 0.05 * np.cos(angle + 1.0)
        columns.append(wave + 1e-3 * random.standard_normal(4_000))
    write("three.csv", "t [s],ia,ib,ic", [time_s, *columns])
    three = ("--csv", "three.csv", "--time", "t", "--current", "ia", "--current", "ib")
    found = measured(invoke(*three, "--current", "ic", "--json"))
    numbers = found["measurements"]
    for name, true in (
        *(("sequence_positive", 5.0), ("sequence_negative", 0.1), ("sequence_zero", 0.05)),
        *(("unbalance_percent", 2.0), ("unbalance_zero_percent", 1.0)),
    ):
        number = numbers[f"current_{name}"]
        assert number["value"] == pytest.approx(true, abs=max(1e-3, 3.0 * number["uncertainty"]["expanded"]))
    assert set(found["source"]["columns"]) == {"time", "current", "current_b", "current_c"}
    assert invoke(*three, "--json").exit_code == 2
    write("dead.csv", "t [s],ia,ib,ic", [time_s, *columns[:2], np.zeros(4_000)])
    dead = measured(invoke("--csv", "dead.csv", *three[2:], "--current", "ic", "--json"))["measurements"]
    assert dead["current_fundamental"]["value"] == pytest.approx(5.0, rel=0.05)
    assert dead["current_unbalance_percent"]["value"] is None
    assert "ic" in dead["current_unbalance_percent"]["reason"]
