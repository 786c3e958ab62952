"""Limits of a profile are supervised wherever a drive is enabled, with any stream or none."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

import benchtool
from benchtool.api import Bench
from benchtool.cli import app
from benchtool.errors import CapabilityMissing, LimitTrip, ValueRefused
from benchtool.profile import profile_path
from benchtool.protocol.cia402 import State

ELSEWHERE = ("torque", "omega_m", "i_a", "i_b", "u_dc", "psi_s", "i_d", "i_q", "theta_m", "law_clipped")


@pytest.fixture
def limited(tmp_path: Path) -> Path:
    """Profile of the paper's machine that must not turn faster than 15 rad/s."""
    text = profile_path("zhu2011").read_text(encoding="utf-8")
    place = tmp_path / "limited.toml"
    place.write_text(f"{text}\n[limits]\nomega_m_rad_s = 15.0\ncurrent_sum_A = 5.0\n", encoding="utf-8")
    return place


@pytest.fixture(params=["emulated", "emulated?wire=serial"])
def bench(limited: Path, request: pytest.FixtureRequest) -> Iterator[Bench]:
    with benchtool.open_bench(limited, request.param) as opened:
        yield opened


def _trips(bench: Bench) -> None:
    with (
        pytest.raises(LimitTrip, match=r"omega_m is 1\d\.\d+ rad/s, the profile's limit is 15 rad/s"),
        bench.drive.enabled("velocity") as running,
    ):
        running.omega_m_command = 12.0
        bench.wait(0.6)
        running.omega_m_command = 18.0
        bench.wait(1.0)
    assert bench.drive.state is State.SWITCH_ON_DISABLED
    bench.wait(0.1)  # it is told once


def test_without_a_stream_of_the_caller(bench: Bench) -> None:
    _trips(bench)
    with bench.drive.enabled("velocity") as running:
        running.omega_m_command = 12.0
        bench.wait(0.6)
        assert running.values["omega_m"] == pytest.approx(12.0, rel=0.1)


def test_within_a_stream_that_has_nothing_of_it(bench: Bench) -> None:
    with bench.drive.stream(["torque"]) as stream:
        _trips(bench)
    assert stream.block.names == ("torque",)
    assert stream.block.gaps == ()


def test_while_streams_begin_and_end_of_an_enabled_drive(bench: Bench) -> None:
    with pytest.raises(LimitTrip), bench.drive.enabled("velocity") as running:
        running.omega_m_command = 12.0
        with bench.drive.stream(["torque"]) as stream:
            bench.wait(0.5)
        assert stream.block.names == ("torque",)
        running.omega_m_command = 18.0
        bench.wait(1.0)


def test_a_stream_without_room_for_what_is_supervised_is_refused(limited: Path) -> None:
    full = [*ELSEWHERE, "u_alpha", "u_beta", "psi_alpha"]
    with benchtool.open_bench(limited) as bench:
        with bench.drive.enabled("velocity"), pytest.raises(ValueRefused, match="the stream has no i_c"):
            bench.drive.stream(full).__enter__()
        with bench.drive.stream(full), pytest.raises(ValueRefused, match="the stream has no i_c"):
            bench.drive.enable("velocity")
        assert bench.drive.state is State.SWITCH_ON_DISABLED


def test_a_jog_ends_at_a_limit(limited: Path) -> None:
    command = ["jog", "--speed", "18", "--duration", "1", "--profile", str(limited)]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == LimitTrip.exit_code
    assert "the profile's limit is 15 rad/s: the drive was told to stop" in result.stderr


def test_a_drive_that_does_not_stream_what_is_limited_is_not_enabled(limited: Path) -> None:
    with benchtool.open_bench(limited) as bench:
        with bench._connection.use() as session:
            data = session.drive.link.process_data
            fitting = data.fitting
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(
                    type(data),
                    "fitting",
                    lambda _, dictionary, names: tuple(
                        each for each in fitting(dictionary, names) if each != "i_c"
                    ),
                )
                with pytest.raises(CapabilityMissing, match="are of i_c, which the drive does not stream"):
                    bench.drive.enable("velocity")
        assert bench.drive.state is State.SWITCH_ON_DISABLED
