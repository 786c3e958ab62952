"""What else runs differ in is told by kind and key, and what cannot be compared with its reason."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.analysis import Basis, Measurement, Uncertainty
from benchtool.cli import app
from benchtool.cli.compare import show
from benchtool.cli.output import Output
from benchtool.plan import Limit
from benchtool.recording import Bundle
from benchtool.results.comparison import Comparison
from benchtool.results.differences import Differences, Kind
from benchtool.results.recordings import assess_recording
from benchtool.shipped import shipped
from tests.unit.results.recorded_specimen import recording, stream

STEADY = [(4.0, 15.7, 0.65)]
TOML = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")


def _between(*bundles: Path) -> Differences:
    results = {path.name: assess_recording(Bundle.open(path))[0] for path in bundles}
    return Differences.of(Comparison.of("", results))


def test_runs_that_are_the_same_differ_in_nothing(tmp_path: Path) -> None:
    for name in "ab":
        recording(tmp_path / name, {"telemetry": stream(STEADY)})
    found = _between(tmp_path / "a", tmp_path / "b")
    assert found.circumstances == ()
    assert found.not_compared == ()
    assert set(found.same) == set(Kind)


def test_a_key_of_the_profile_is_named(tmp_path: Path) -> None:
    other = TOML.replace("R_s_ohm = 0.123", "R_s_ohm = 0.2") + "\n[bench.clock]\ntolerance_ppm = 50\n"
    for name, toml in (("a", TOML), ("b", other)):
        recording(tmp_path / name, {"telemetry": stream(STEADY)}, toml=toml)
    found = _between(tmp_path / "a", tmp_path / "b").of_kind(Kind.PROFILE)
    values = {each.key: tuple(each.values.values()) for each in found}
    assert values["motor.R_s_ohm"] == (0.123, 0.2)
    assert values["bench.clock.tolerance_ppm"] == (None, 50.0)


def test_what_is_left_empty_is_as_what_is_not_there(tmp_path: Path) -> None:
    """A sensor without a serial number was listed with one that is blank."""
    sensor = '\n[bench.channels.i_a]\ngain_U_percent = 0.2\ncertificate = "C7"\n'
    for name, toml in (("a", TOML), ("b", f"{TOML}{sensor}")):
        recording(tmp_path / name, {"telemetry": stream(STEADY)}, toml=toml)
    found = _between(tmp_path / "a", tmp_path / "b").of_kind(Kind.PROFILE)
    assert {tuple(each.values.values()) for each in found} == {(None, 0.2), (None, "C7")}


def test_a_default_that_is_written_out_is_no_difference(tmp_path: Path) -> None:
    recording(tmp_path / "a", {"telemetry": stream(STEADY)})
    recording(tmp_path / "b", {"telemetry": stream(STEADY)}, toml=f"# a remark\n{TOML}")
    assert _between(tmp_path / "a", tmp_path / "b").circumstances == ()


def test_operating_points_that_were_reached_are_told_apart_beyond_their_tolerance(tmp_path: Path) -> None:
    for name, speed in (("a", 15.7), ("near", 15.9), ("far", 20.0)):
        recording(tmp_path / name, {"telemetry": stream([(4.0, speed, 0.65)])})
    assert _between(tmp_path / "a", tmp_path / "near").circumstances == ()
    (only,) = _between(tmp_path / "a", tmp_path / "far").circumstances
    assert (only.kind, only.key) == (Kind.REACHED, "omega_m_reached")
    assert tuple(only.values.values()) == pytest.approx((15.7, 20.0), rel=1e-3)


def test_rate_and_channels_differ_and_what_only_one_has_is_not_compared(tmp_path: Path) -> None:
    recording(tmp_path / "a", {"telemetry": stream(STEADY)})
    recording(tmp_path / "b", {"telemetry": stream(STEADY, 500.0, channels=("torque", "omega_m"))}, link="x")
    found = _between(tmp_path / "a", tmp_path / "b")
    assert [each.key for each in found.of_kind(Kind.RECORDED)] == ["rate_Hz", "stride", "channels"]
    assert [tuple(each.values.values()) for each in found.of_kind(Kind.SOFTWARE)] == [("", "x")]
    reasons = {each.name: each.reason for each in found.not_compared}
    assert reasons["fundamental_frequency"] == "b has none"
    assert "torque_mean" not in reasons


def test_text_json_and_page_tell_it_before_the_numbers(tmp_path: Path) -> None:
    recording(tmp_path / "a", {"telemetry": stream(STEADY)})
    other = TOML.replace("R_s_ohm = 0.123", "R_s_ohm = 0.2")
    recording(tmp_path / "b", {"telemetry": stream([(4.0, 20.0, 0.65)])}, toml=other)
    runs, page = [str(tmp_path / name) for name in "ab"], tmp_path / "page.html"
    result = CliRunner().invoke(app, ["compare", *runs, "--json", "--html", str(page)])
    assert result.exit_code == 0, result.output
    shown = result.stderr  # what is for people, beside the document
    for said in ("motor.R_s_ohm", "omega_m_reached", "the same in all runs: drive parameters"):
        assert 0 < shown.index(said) < shown.index("torque_mean")
    document = json.loads(result.stdout)["circumstances"]["comparison"]
    assert document["runs"] == ["a", "b"]
    assert document["differing"]["profile"] == {"motor.R_s_ohm": [0.123, 0.2]}
    assert list(document["differing"]["operating point reached"]) == ["omega_m_reached"]
    assert "limits" in document["same"]
    text = page.read_text(encoding="utf-8")
    assert 0 < text.index("motor.R_s_ohm") < text.index("torque_mean")


def test_what_transducers_of_two_bands_contradict_is_printed_for_each_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results = {}
    for name, band_Hz in (("a", 200.0), ("b", 2000.0)):
        recording(tmp_path / name, {"telemetry": stream(STEADY)})
        result = assess_recording(Bundle.open(tmp_path / name))[0]
        own = Uncertainty(0.001, "test")
        narrow = Measurement("torque_mean", 0.63, "Nm", "", Basis(bandwidth_Hz=band_Hz), own)
        found = (
            Measurement("torque_mean", 0.65, "Nm", "", uncertainty=own, in_common_band=narrow),
            Measurement("transducer_torque_mean", 0.6, "Nm", "", uncertainty=own),
        )
        results[name] = replace(result, measurements=found, limits={"torque_mean": Limit(min=0.62)})
    show(Output(as_json=False), Comparison.of("", results))
    printed = " ".join(capsys.readouterr().out.split())
    for letter, band_Hz in (("A", 200), ("B", 2000)):
        assert f"the transducer disagrees: {letter}: torque_mean is 0.6500" in printed
        assert f"in the transducer's band, up to {band_Hz} Hz, where the transducer reads 0.6000" in printed
    assert printed.count("); on the shaft it is 0.6000") == 2
    assert printed.count("(fail)") == 2
