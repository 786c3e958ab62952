"""Torque residual: torque predicted one period ahead by a model of the machine, minus the measured torque.

The residual shows how well the machine's parameters fit: its mean shows flux linkage and resistance, its rms,
above the noise of the measured currents, the inductances.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.crop import crop_to
from benchtool.analysis.declaration import Analysis, Findings, NoSettings, Quantity
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.statistics.scatter import TOO_SLOW, MeanError, error_of_record, error_of_root
from benchtool.analysis.uncertainty import combined
from benchtool.analysis.validity import require_finite_channels, require_unbroken
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.profile import Motor

NEEDED: Final = ("i_a", "i_b", "i_c", "theta_m", "omega_m", "u_alpha", "u_beta", "torque")
"""Channels from which the torque of the next row is predicted, and that with which it is compared."""

_FEWEST_ROWS = 20
_SCATTER = "scatter over parts of the record, with their correlation"
_CHUNK = 1 << 16  # rows at a time: little memory

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


def torque_residual(block: Block, motor: Motor, transducer: Block | None = None) -> tuple[Measurement, ...]:
    """Return the predicted minus measured torque, row by row.

    The stator flux of row k, by the model from the currents and the angle measured there, moves by
    T_s (u - R_s i): u is the voltage asked in row k - 1, which is the one on the motor from row k to k + 1,
    taken as its mean, and i the mean of the currents at both ends: that of row k + 1 is the predicted one,
    first with the drop of row k alone, then once more with the mean. The rotor turns on at the measured
    speed. Flux and angle give currents and torque at row k + 1:

        psi = (L_d i_d + psi_r) + j L_q i_q,     torque = 3/2 p (psi_d i_q - psi_q i_d)

    `torque_residual` compares that with the drive's estimate in row k + 1, which is made of the drive's own
    parameters. `transducer_torque_residual` compares the mean of the modelled torque at both ends of the
    period with the mean of the transducer over the period. Dead time and device drops are not modelled.

    Args:
        block: a capture without gaps, every tick, with the channels `NEEDED`.
        motor: the parameters under test.
        transducer: channel torque_transducer, if there is one.

    Raises:
        AnalysisError: a gap, a missing channel, a number that is not finite, fewer than 20 rows, or ticks
            were left out between rows.
    """
    require_unbroken(block)
    if block.stride != 1:
        raise AnalysisError(
            f"the capture holds one tick in {block.stride}, each is needed to predict the next: "
            f"record with stride = 1"
        )
    if len(block.data) < _FEWEST_ROWS:
        raise AnalysisError(
            f"{len(block.data)} rows to predict torque in, at least {_FEWEST_ROWS} are needed: record longer"
        )
    require_finite_channels(block, NEEDED)
    now_Nm, next_Nm = _predict(block, motor)
    measured_Nm = block.column("torque")
    rate_Hz = block.sample_rate_Hz
    basis = Basis(
        samples=len(next_Nm),
        sample_rate_Hz=rate_Hz,
        duration_s=len(next_Nm) / rate_Hz,
        bandwidth_Hz=0.5 * rate_Hz,
        reference=(
            f"R_s {motor.R_s_ohm:g} ohm, L_d {motor.L_d_H:g} H, L_q {motor.L_q_H:g} H, psi_r "
            f"{motor.psi_r_Wb:g} Wb, p {motor.pole_pairs}"
        ),
        gaps=0,
    )
    found = list(_of_estimate(next_Nm - measured_Nm[2:], float(np.std(measured_Nm[2:])), basis))
    if transducer is not None:
        over_period = 0.5 * (now_Nm + next_Nm)
        found.extend(_of_transducer(over_period, crop_to(transducer, block), block, basis))
    return tuple(found)


def _predict(block: Block, motor: Motor) -> tuple[Floats, Floats]:
    """Return the modelled torque in rows 1 to n - 2, and predicted torque one row after each, both of shape
    (n - 2,)."""
    rows = len(block.data) - 2
    now_Nm, next_Nm = np.empty(rows), np.empty(rows)
    columns = {name: block.column(name) for name in NEEDED}
    for first in range(0, rows, _CHUNK):
        last = min(first + _CHUNK, rows)
        part = {name: column[first : last + 2] for name, column in columns.items()}
        now_Nm[first:last], next_Nm[first:last] = _predict_part(part, motor, 1.0 / block.sample_rate_Hz)
    return now_Nm, next_Nm


def _predict_part(columns: Mapping[str, Floats], motor: Motor, T_s: float) -> tuple[Floats, Floats]:
    """`_predict` of some rows in a row."""
    a, b, c = (columns[name][1:-1] for name in ("i_a", "i_b", "i_c"))
    i_s = (2.0 * a - b - c) / 3.0 + 1j * (b - c) / math.sqrt(3.0)
    theta_e = motor.pole_pairs * columns["theta_m"][1:-1]
    u_s = columns["u_alpha"][:-2] + 1j * columns["u_beta"][:-2]

    rotor = np.exp(1j * theta_e)
    i_now = i_s * np.conj(rotor)
    psi_now = (motor.L_d_H * i_now.real + motor.psi_r_Wb) + 1j * motor.L_q_H * i_now.imag
    psi_s = psi_now * rotor
    forth = rotor * np.exp(1j * motor.pole_pairs * T_s * columns["omega_m"][1:-1])
    back = np.conj(forth)
    psi_next = (psi_s + T_s * (u_s - motor.R_s_ohm * i_s)) * back
    # with the currents that this gives, the drop is that of the mean of both ends
    mean_i_s = 0.5 * (i_s + _current(psi_next, motor) * forth)
    psi_next = (psi_s + T_s * (u_s - motor.R_s_ohm * mean_i_s)) * back
    return _torque(psi_now, i_now, motor), _torque(psi_next, _current(psi_next, motor), motor)


def _current(psi: Complex, motor: Motor) -> Complex:
    """Return the d-current as real, q-current as imaginary part, of a flux in the same form."""
    return np.asarray((psi.real - motor.psi_r_Wb) / motor.L_d_H + 1j * psi.imag / motor.L_q_H)


def _torque(psi: Complex, i: Complex, motor: Motor) -> Floats:
    return np.asarray(1.5 * motor.pole_pairs * (psi.real * i.imag - psi.imag * i.real))


def _of_estimate(residual_Nm: Floats, ripple_Nm: float, basis: Basis) -> Iterator[Measurement]:
    what = (
        "torque predicted one period ahead from currents, angle, speed and voltage (for the resistive drop, "
        "the current at its end as predicted) minus the drive's estimate"
    )
    yield from _mean_and_rms(residual_Nm, "torque_residual", what, basis)
    text = f"greatest magnitude of {what}"
    greatest, why = float(np.max(np.abs(residual_Nm))), "one record tells one greatest magnitude"
    yield Measurement("torque_residual_max", greatest, "Nm", text, basis, uncertainty_reason=why)
    name = "torque_residual_percent_of_ripple"
    text = "100 x rms of torque_residual about its mean / rms of the drive's estimate about its mean"
    if ripple_Nm > 0.0:
        share, why = 100.0 * float(np.std(residual_Nm)) / ripple_Nm, "how both rms go together is not told"
        yield Measurement(name, share, "%", text, basis, uncertainty_reason=why)
    else:
        yield Measurement.undefined(name, "%", text, "the torque is constant", basis)


def _of_transducer(
    modelled_Nm: Floats, transducer: Block, block: Block, basis: Basis
) -> Iterator[Measurement]:
    basis = replace(basis, alignment_s=transducer.alignment_s or None)
    each = round(transducer.sample_rate_Hz / block.sample_rate_Hz)
    torque_Nm = transducer.column("torque_transducer")
    rows = min(len(modelled_Nm), len(torque_Nm) // max(1, each) - 1)
    what = "modelled torque, of both ends of a period, minus torque_transducer, of all its rows in the period"
    if each < 1 or not math.isclose(each * block.sample_rate_Hz, transducer.sample_rate_Hz) or rows < 2:
        reason = f"{raw(transducer.sample_rate_Hz)} Hz is no multiple of {raw(block.sample_rate_Hz)} Hz"
        yield Measurement.undefined("transducer_torque_residual_mean", "Nm", what, reason, basis)
        return
    true_Nm = np.mean(torque_Nm[each : (rows + 1) * each].reshape(rows, each), axis=1)
    yield from _mean_and_rms(modelled_Nm[:rows] - true_Nm, "transducer_torque_residual", what, basis)


def _mean_and_rms(residual_Nm: Floats, name: str, what: str, basis: Basis) -> Iterator[Measurement]:
    mean = float(np.mean(residual_Nm))
    text = f"mean of {what}"
    yield _scatter(Measurement(f"{name}_mean", mean, "Nm", text, basis), error_of_record(residual_Nm))
    rms = float(np.sqrt(np.mean(residual_Nm**2)))
    square = residual_Nm**2
    of_rms = Measurement(f"{name}_rms", rms, "Nm", f"rms, with the mean, of {what}", basis)
    yield _scatter(of_rms, error_of_root(square, rms, error_of_record(square)))


def _scatter(measured: Measurement, error: MeanError) -> Measurement:
    """Return a measurement with the uncertainty by the scatter of its samples, or why it has none."""
    uncertain = combined([error.line(_SCATTER)], _SCATTER)
    why = TOO_SLOW if uncertain is None else ""
    return replace(measured, uncertainty=uncertain, uncertainty_reason=why)


def _of_window(window: Window) -> tuple[Measurement, ...]:
    """Return the torque residual; nothing without a motor."""
    return () if window.motor is None else torque_residual(window.block, window.motor, window.transducer)


def _measure(window: Window, _: NoSettings) -> Findings:
    found = window.cached(_of_window)
    return Findings(tuple(each for each in found if RESIDUAL.quantity(each.name)))


def _measure_transducer(window: Window, _: NoSettings) -> Findings:
    found = window.cached(_of_window)
    return Findings(tuple(each for each in found if TRANSDUCER_RESIDUAL.quantity(each.name)))


RESIDUAL: Final = Analysis(
    name="torque_residual",
    title="torque residual",
    measure=_measure,
    quantities=(
        Quantity(
            ("torque_residual_mean", "torque_residual_rms", "torque_residual_max"),
            "Nm",
            "of predicted torque minus the drive's estimate in the row predicted; rms with the mean, "
            "greatest magnitude",
        ),
        Quantity(
            ("torque_residual_percent_of_ripple",),
            "%",
            "`100 x` rms of the residual about its mean / rms of the estimate about its mean",
        ),
    ),
    settings=NoSettings,
    channels=NEEDED,
    every_tick=True,
)
TRANSDUCER_RESIDUAL: Final = Analysis(
    name="transducer_torque_residual",
    title="torque residual on the shaft",
    measure=_measure_transducer,
    quantities=(
        Quantity(
            ("transducer_torque_residual_mean", "transducer_torque_residual_rms"),
            "Nm",
            "of the mean of modelled torque in row k and predicted torque in row k + 1 minus the mean of the "
            "transducer from k to k + 1",
        ),
    ),
    settings=NoSettings,
    channels=NEEDED,
    transducer=True,
    every_tick=True,
)
