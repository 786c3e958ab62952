"""A motor from its nameplate: every convention says the same of one machine."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import ProfileError
from benchtool.profile.nameplate import (
    VOLTAGE_SHARE,
    Amplitude,
    Nameplate,
    Voltage,
    Winding,
    flux_of_ke,
    flux_of_kt,
    flux_of_kv,
)

plates = st.builds(
    Nameplate,
    pole_pairs=st.integers(1, 21),
    R_s_ohm=st.floats(1e-3, 0.05),
    L_d_H=st.floats(3e-6, 1e-3),
    L_q_H=st.floats(3e-6, 1e-3),
    psi_r_Wb=st.floats(1e-3, 0.5),
    J_kgm2=st.floats(1e-6, 1e-2),
    u_dc_V=st.floats(12.0, 600.0),
    I_N_A=st.floats(1.0, 60.0),
)


def _induced_V(voltage: Voltage, pole_pairs: int, psi_r_Wb: float, omega_m: float) -> float:
    """No-load voltage by its waveforms, sampled over a period, and not by factors."""
    angles = [2.0 * math.pi * n / 3600 for n in range(3600)]
    peak = pole_pairs * omega_m * psi_r_Wb
    phase_a = [peak * math.cos(angle) for angle in angles]
    phase_b = [peak * math.cos(angle - 2.0 * math.pi / 3.0) for angle in angles]
    line = [a - b for a, b in zip(phase_a, phase_b, strict=True)]
    wave = line if voltage.value.startswith("ll") else phase_a
    if voltage.value.endswith("rms"):
        return math.sqrt(sum(value * value for value in wave) / len(wave))
    return max(wave)


@pytest.mark.parametrize("voltage", list(Voltage))
def test_the_constant_of_a_voltage_that_the_machine_induces_is_its_flux(voltage: Voltage) -> None:
    induced_V = _induced_V(voltage, 7, 0.0123, 100.0)
    assert flux_of_ke(induced_V / 100.0, voltage, 7) == pytest.approx(0.0123, rel=1e-5)
    assert flux_of_kv(100.0 / induced_V, voltage, 7) == pytest.approx(0.0123, rel=1e-5)


def test_published_motors() -> None:
    # ebm-papst ECI 63.20: 8.485 V peak line to line at 1000 rpm, 4 pole pairs, identified with 11.70 mWb
    assert flux_of_ke(8.485 / (1000.0 * math.pi / 30.0), Voltage.LINE_PEAK, 4) == pytest.approx(
        11.70e-3, rel=2e-3
    )
    # the machine of Zhu, Xiao and Li: 1.43 Nm per A rms, 4 pole pairs, 0.1685 Wb
    assert flux_of_kt(1.43, Amplitude.RMS, 4) == pytest.approx(0.1685, rel=1e-3)
    # QS138, Kv 58 per volt of dc link, 5 pole pairs, identified with 19.0 mWb
    assert flux_of_kv(58.0 * math.pi / 30.0, Voltage.LINE_PEAK, 5) == pytest.approx(19.0e-3, rel=2e-3)
    assert Winding.LINE_TO_LINE.per_phase * 0.72 == pytest.approx(0.36)  # Teknic M-2310P


@given(plates)
def test_at_the_rated_point_the_voltage_and_the_current_are_used(plate: Nameplate) -> None:
    motor = plate.motor()
    u = VOLTAGE_SHARE * plate.u_dc_V / math.sqrt(3.0)
    if plate.R_s_ohm * plate.I_N_A >= u:
        return
    best = 0.0
    for n in range(2001):  # most torque of the current, by trying all angles
        angle = math.pi / 2.0 + math.pi / 2.0 * (n - 1000) / 1000.0
        i_d, i_q = plate.I_N_A * math.cos(angle), plate.I_N_A * math.sin(angle)
        torque = 1.5 * plate.pole_pairs * (plate.psi_r_Wb + (plate.L_d_H - plate.L_q_H) * i_d) * i_q
        if torque > best:
            best, (at_d, at_q) = torque, (i_d, i_q)
    assert motor.T_N_Nm == pytest.approx(best, rel=1e-4)
    omega_e = plate.pole_pairs * motor.omega_m_N_rad_s
    u_d = plate.R_s_ohm * at_d - omega_e * plate.L_q_H * at_q
    u_q = plate.R_s_ohm * at_q + omega_e * (plate.psi_r_Wb + plate.L_d_H * at_d)
    assert math.hypot(u_d, u_q) == pytest.approx(u, rel=2e-2)
    assert motor.I_N_A_rms == pytest.approx(plate.I_N_A / math.sqrt(2.0))


def test_a_convention_that_was_mixed_up_is_seen_where_torque_or_speed_are_stated() -> None:
    stated = {"pole_pairs": 4, "R_s_ohm": 0.123, "L_d_H": 9.52e-3, "L_q_H": 9.52e-3, "J_kgm2": 1e-3}
    rated = {"u_dc_V": 311.0, "I_N_A": 6.7 * math.sqrt(2.0), "T_N_Nm": 9.55, "omega_m_N_rad_s": 157.1}
    assert Nameplate(**stated, **rated, psi_r_Wb=0.1685).contradictions() == []  # type: ignore[arg-type]
    mixed = Nameplate(**stated, **rated, psi_r_Wb=0.1685 * math.sqrt(2.0)).contradictions()  # type: ignore[arg-type]
    assert len(mixed) == 1
    assert "makes 13.5 Nm with this flux, and the rated torque is 9.55 Nm" in mixed[0]
    slow = Nameplate(**stated, **(rated | {"u_dc_V": 100.0}), psi_r_Wb=0.1685).contradictions()  # type: ignore[arg-type]
    assert "the dc link allows 66.62" in slow[0]


def test_a_current_that_the_dc_link_cannot_drive_is_refused() -> None:
    plate = Nameplate(
        pole_pairs=7, R_s_ohm=5.29, L_d_H=1e-3, L_q_H=1e-3, psi_r_Wb=6e-3, J_kgm2=2e-6, u_dc_V=12.0, I_N_A=3.0
    )
    with pytest.raises(ProfileError, match=r"takes 15\.87 V per phase at standstill.* leaves 6\.235 V"):
        plate.motor()
