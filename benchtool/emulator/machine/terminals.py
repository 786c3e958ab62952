"""What the terminals of the machine see: its inductance, its EMF, and what is in series with the phases."""

from __future__ import annotations

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.asymmetry import Asymmetry, Symmetric, through_asymmetry, with_asymmetry
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.harmonics import flux_slope
from benchtool.emulator.machine.saturation import Saturation, incremental
from benchtool.emulator.machine.state import State, electrical


@called
def _inverse_inductance(saturation: Saturation | None, m: Machine, y_d: float, y_q: float) -> Symmetric:
    """Return by what the rates of the currents change with the voltage, in 1/H."""
    if saturation is None:
        return Symmetric(m.inv_L_d, 0.0, m.inv_L_q)
    G = incremental(saturation, y_d, y_q)
    return Symmetric(m.inv_L_d * G.dd, m.inv_L_d * G.dq, m.inv_L_d * G.qq)


@called
def inverse_inductance(x: State, m: Machine) -> Symmetric:
    """Return by what the rates of the currents change with the voltage at the terminals, in d/q, in 1/H."""
    y_d, y_q = electrical(m.saturation, x)
    return through_asymmetry(
        m.asymmetry, x.cos_theta, x.sin_theta, _inverse_inductance(m.saturation, m, y_d, y_q)
    )


@called
def open_circuit_voltage(x: State, m: Machine) -> tuple[float, float]:
    """Return the voltage in d/q at which no current begins to flow."""
    g_d, g_q = flux_slope(m.harmonics, x.cos_theta, x.sin_theta)
    return x.omega_e * g_d, x.omega_e * (m.psi_r + g_q)


@njit
def in_series(
    asymmetry: Asymmetry | None,
    dy_d: float,
    dy_q: float,
    y_d: float,
    y_q: float,
    i_d: float,
    i_q: float,
    omega_e: float,
    cos_theta: float,
    sin_theta: float,
    m: Machine,
) -> tuple[float, float]:
    """Return the rates of the electrical states with what is in series with the phases."""
    if asymmetry is None:
        return dy_d, dy_q
    G = _inverse_inductance(m.saturation, m, y_d, y_q)
    di_d, di_q = of_currents(m.saturation, y_d, y_q, dy_d, dy_q)
    di_d, di_q = with_asymmetry(asymmetry, di_d, di_q, i_d, i_q, omega_e, cos_theta, sin_theta, G)
    return _of_states(m.saturation, y_d, y_q, di_d, di_q)


@njit
def of_currents(
    saturation: Saturation | None, y_d: float, y_q: float, dy_d: float, dy_q: float
) -> tuple[float, float]:
    """Return the rates of the currents for those of the electrical states."""
    if saturation is None:
        return dy_d, dy_q
    G = incremental(saturation, y_d, y_q)
    return G.dd * dy_d + G.dq * dy_q, G.dq * dy_d + G.qq * dy_q


@njit
def _of_states(
    saturation: Saturation | None, y_d: float, y_q: float, di_d: float, di_q: float
) -> tuple[float, float]:
    """Return the rates of the electrical states for those of the currents."""
    if saturation is None:
        return di_d, di_q
    G = incremental(saturation, y_d, y_q)
    per = 1.0 / (G.dd * G.qq - G.dq * G.dq)
    return (G.qq * di_d - G.dq * di_q) * per, (G.dd * di_q - G.dq * di_d) * per
