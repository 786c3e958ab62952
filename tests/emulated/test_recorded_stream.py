"""A stream beside a capture of the same run: the same numbers within their uncertainties, and no others."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.analysis.uncertainty import of_difference
from benchtool.block import Block
from benchtool.cli import app
from benchtool.drive import Capture, CaptureRequest
from benchtool.plan.model import OperatingPoint
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle, BundleWriter, Conditions
from benchtool.results.block_result import analyze
from benchtool.results.recordings import Selection, assess_recording
from benchtool.run.case import _settle
from benchtool.run.recording import manifest_of
from benchtool.telemetry import record_stream

from .conftest import Opener
from .test_runs import RunObserver

CHANNELS = ("torque", "i_a", "omega_m", "theta_m", "psi_s")
POINT = OperatingPoint(omega_m_rad_s=31.4, load_torque_Nm=0.65, settle_s=1.0)


def _recorded(open_wire: Opener, folder: Path, options: str, rate_Hz: float) -> tuple[Bundle, Block]:
    """A stream of 0.6 s of a steady state, and a capture of half of that time."""
    session = open_wire(options=options).session
    drive = session.drive
    identity = drive.connect()
    manifest = manifest_of(
        session,
        identity,
        what="record",
        when="2026-03-01T10:00:00",
        wall_s=0.0,
        note="",
        conditions=Conditions(),
        seed=0,
        link="emulated",
        command_line=(),
        details={},
    )
    with drive.enabled(Mode.VELOCITY):
        _settle(session, POINT, RunObserver())
        with BundleWriter(folder, manifest) as bundle:
            with record_stream(drive, bundle, CHANNELS, rate_Hz) as stream:
                capture = Capture(drive, CaptureRequest(CHANNELS, 3000))
                capture.wait()
                stream.check()
                block = capture.read()
                drive.wait(0.1)
            return bundle.finish(), block


def test_a_stream_of_every_tick_is_the_capture(open_wire: Opener, tmp_path: Path) -> None:
    bundle, capture = _recorded(open_wire, tmp_path / "a", "&wire=serial", 10_000.0)
    profile = open_wire().session.profile
    stream = bundle.block("telemetry")
    from_s = (capture.first_tick - stream.first_tick) * stream.tick_s
    (same,) = assess_recording(bundle, Selection(from_s=from_s, to_s=from_s + 0.3))
    expected = analyze(capture, profile)
    assert same.capture.ticks().tolist() == capture.ticks().tolist()
    found = {each.name: each.value for each in same.measurements}
    for each in expected:
        assert found[each.name] == pytest.approx(each.value, rel=1e-12, nan_ok=True), each.name
    assert math.isfinite(found["torque_ripple_pp"])
    assert math.isfinite(found["current_thd_f"])


@pytest.mark.parametrize("rate_Hz", [1000.0, 250.0])
def test_a_slow_stream_tells_what_its_rate_allows(open_wire: Opener, tmp_path: Path, rate_Hz: float) -> None:
    bundle, capture = _recorded(open_wire, tmp_path / "a", "", rate_Hz)
    expected = analyze(capture, open_wire().session.profile)
    (found,) = assess_recording(bundle)
    compared = beyond = 0
    for each in found.measurements:
        if each.name not in expected or not math.isfinite(each.value):
            continue
        other = expected[each.name]
        assert each.uncertainty is not None, each.name
        assert other.uncertainty is not None, each.name
        U = of_difference(each.uncertainty, other.uncertainty).expanded
        apart = abs(each.value - other.value)
        assert apart <= 2.0 * U, each.name
        compared, beyond = compared + 1, beyond + (apart > U)
    assert compared >= 5
    assert beyond <= 1, "U covers 95 %"
    for name in ("torque_ripple_pp", "flux_ripple_pp", "current_thd_f", "current_noise_floor"):
        assert math.isnan(found.found[name].value)
        assert found.found[name].reason


@pytest.mark.usefixtures("blank_pictures")
def test_what_record_wrote_is_analysed_reported_and_compared(tmp_path: Path) -> None:
    def done(*arguments: object) -> str:
        result = CliRunner().invoke(app, [str(each) for each in arguments])
        assert result.exit_code == 0, result.output
        return result.stdout

    folder = tmp_path / "a"
    done("record", "--duration", "1", "--out", folder)
    case = json.loads(done("analyze", folder, "--json"))["cases"]["telemetry"]
    assert case["measurements"]["omega_m_reached"]["value"] == 0.0
    assert all(each["value"] is not None or each["reason"] for each in case["measurements"].values())
    done("report", folder)
    assert "What was measured" in (folder / "report.html").read_text(encoding="utf-8")
    part = json.loads(done("analyze", folder, "--from", 0.5, "--analysis", "torque_spectrum=false", "--json"))
    (name,) = part["cases"]
    assert name == "telemetry 0.5-1 s"
    assert "torque_line_frequency" not in part["cases"][name]["measurements"]
    assert json.loads(done("compare", folder, folder, "--json"))["deltas"]
