"""Control and PWM rates of the profile: 5 to 40 kHz and double update, over both wires, with right time axes.

The load machine holds the shaft, so that speed and electrical frequency are known without a controller.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import benchtool
from benchtool.bench import open_session
from benchtool.drive import Capture, CaptureRequest
from benchtool.errors import ParameterMismatch, ProfileError, ValueRefused
from benchtool.profile import load_profile, profile_path
from benchtool.protocol import Mode
from benchtool.run.parameter_check import check_parameters
from benchtool.telemetry import TelemetryStream
from tests.at_length import at_length

from .conftest import Opener, over_both_wires
from .test_telemetry import Kept

HELD_RAD_S = 40.0
POLE_PAIRS = 4
COUNT_RAD = 2.0 * math.pi / 10_000
CHANNELS = ("i_a", "i_b", "i_c", "torque", "theta_m", "switching_count")


def profile_of(folder: Path, control_period_s: float, pwm_period_s: float = 0.0) -> str:
    """Return the file of the paper's profile for a drive with these periods."""
    stated = f"[drive]\ncontrol_period_s = {control_period_s!r}\n"
    if pwm_period_s:
        stated += f"pwm_period_s = {pwm_period_s!r}\n"
    file = folder / "profile.toml"
    file.write_text(profile_path("zhu2011").read_text().replace("[drive]\n", stated, 1))
    return str(file)


@over_both_wires
@pytest.mark.parametrize(
    ("control_us", "pwm_us"),
    [(200, 200), (50, 50), (25, 25), (50, 100), *at_length((100, 100), (33, 33))],
    ids=str,
)
def test_speed_and_frequency_on_the_time_axis(
    open_wire: Opener, link_options: str, tmp_path: Path, control_us: int, pwm_us: int
) -> None:
    T_s, serial = round(1e3 * control_us) * 1e-9, "serial" in link_options
    session = open_wire(profile_of(tmp_path, T_s, pwm_us * 1e-6), options=link_options).session
    drive, kept = session.drive, Kept()
    drive.write("law", "foc")
    assert session.load is not None
    session.load.hold(HELD_RAD_S)
    with drive.enabled(Mode.TORQUE):
        drive.write("torque_command", 3.0)
        drive.wait(0.05)
        begun_s = session.clock.now_s()
        rate_Hz = 1.0 / T_s if serial else 1000.0
        with TelemetryStream(drive, [kept.sink], CHANNELS, rate_Hz) as stream:
            rows = round(0.25 / T_s)
            capture = Capture(drive, CaptureRequest(CHANNELS, rows=rows))
            capture.wait()
            stream.check()
        took_s = session.clock.now_s() - begun_s
        captured = capture.read()

    assert captured.tick_s == T_s
    assert captured.stride == 1
    result = benchtool.analyze(captured, load_profile("zhu2011"))
    frequency = result["fundamental_frequency"]
    assert frequency.uncertainty is not None
    f_e_Hz = POLE_PAIRS * HELD_RAD_S / (2.0 * math.pi)
    assert abs(frequency.value - f_e_Hz) <= frequency.uncertainty.expanded < 0.01
    assert result["torque_mean"].value == pytest.approx(3.0, rel=5e-3)
    switched_Hz = result["switching_frequency_mean"]
    assert switched_Hz.value == pytest.approx(1e6 / pwm_us, abs=1.0 / captured.duration_s)

    streamed = kept.blocks[0]
    assert {block.tick_s for block in kept.blocks} == {T_s}
    assert streamed.stride == (1 if serial else round(1e-3 / T_s))
    times_s = np.concatenate([block.ticks() for block in kept.blocks]) * T_s
    theta = np.unwrap(kept.data[:, CHANNELS.index("theta_m")])
    turned_s = times_s - times_s[0]
    assert np.abs(theta - theta[0] - HELD_RAD_S * turned_s).max() <= COUNT_RAD
    assert turned_s[-1] == pytest.approx(took_s, abs=0.05)


def test_a_second_is_as_many_ticks_as_the_control_rate_says(tmp_path: Path) -> None:
    with open_session(profile_of(tmp_path, 25e-6), "emulated") as session:
        drive = session.drive
        drive.connect()
        first = int(drive.number("tick"))
        drive.wait(1.0)
        assert int(drive.number("tick")) - first == 40_000


@over_both_wires
def test_a_drive_of_another_rate_than_the_profile_states_is_not_enabled(
    open_wire: Opener, link_options: str, tmp_path: Path
) -> None:
    session = open_wire(options=link_options).session
    session.drive.connect()
    stated = load_profile(profile_of(tmp_path, 50e-6, 100e-6))
    check = check_parameters(session.drive, stated, ())
    with pytest.raises(ParameterMismatch, match=r"control_period_s = 0\.0001 \(the profile states 5e-05\)"):
        check.require_equal()
    same = load_profile(profile_of(tmp_path, 100e-6))
    check_parameters(session.drive, same, ()).require_equal()


def test_frequencies_beyond_half_of_the_control_rate_are_refused() -> None:
    played = benchtool.Stimulus(
        quantity="torque", shape="sine", amplitude_Nm=1.0, duration_s=0.1, frequency_Hz=9000.0
    )
    assert played.table(50e-6)["stimulus_frequency_start"] == 9000.0
    with pytest.raises(ValueRefused, match=r"plays up to 5000 Hz"):
        played.table(100e-6)


@pytest.mark.parametrize(
    ("stated", "reason"),
    [
        ((24e-6,), "5 to 40 kHz"),
        ((250e-6,), "5 to 40 kHz"),
        ((25e-6, 75e-6), "two with double update"),
        ((33.3333333e-6,), "whole number of nanoseconds"),
    ],
)
def test_periods_that_cannot_be_are_refused(tmp_path: Path, stated: tuple[float, ...], reason: str) -> None:
    with pytest.raises(ProfileError, match=reason):
        load_profile(profile_of(tmp_path, *stated))
