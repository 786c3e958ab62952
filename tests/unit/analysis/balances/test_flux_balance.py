"""Parameters by the flux balance, from a machine that another formulation integrates."""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import signal
from scipy.stats import multivariate_normal

from benchtool.analysis import Window
from benchtool.analysis.balances.angle import smooth_angle
from benchtool.analysis.balances.flux_balance import ESTIMATED, FluxBalance, flux_balance
from benchtool.analysis.balances.flux_measurements import FLUX_BALANCE, FluxBalanceSettings
from benchtool.analysis.balances.flux_model import Electrical, Ticks, current_of
from benchtool.analysis.balances.motion_balance import motion_balance
from benchtool.analysis.balances.pwm_period import Edges
from benchtool.analysis.balances.space_vectors import Complex, Floats, phase_values, space_vector
from benchtool.analysis.balances.unknowns import Solution, solve
from benchtool.analysis.balances.whitening import Whitening
from benchtool.block import Block, Gap
from benchtool.errors import AnalysisError
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.excited_machine import T_S, Excitation, Truth, capture, motor_with

FLAWED = Truth(
    motor_with(R_s_ohm=0.14, L_d_H=8e-3, L_q_H=13e-3, psi_r_Wb=0.11, J_kgm2=8e-4),
    friction_Nms=1e-3,
    coulomb_Nm=0.05,
    dead_time_V=1.5,
    encoder_offset_rad=0.08,
    gains=(1.01, 0.99, 1.0),
)
STEADY = Excitation(i_q_Hz=0.0, i_d_A=0.0, speed_rad_s=60.0)


def space_columns(i_s: np.ndarray, theta_m: np.ndarray, u_s: complex) -> Block:
    """Return rows of these currents and angles at a voltage that is held."""
    phases = phase_values(i_s)
    columns = dict(zip(("i_a", "i_b", "i_c"), phases, strict=True)) | {
        "theta_m": theta_m,
        "u_alpha": np.full(len(i_s), u_s.real),
        "u_beta": np.full(len(i_s), u_s.imag),
        "u_dc": np.full(len(i_s), 400.0),
    }
    return Block.from_arrays(1.0 / T_S, {}, **columns)


def truth_of(truth: Truth) -> dict[str, float]:
    motor = truth.motor
    return {
        "R_s": motor.R_s_ohm,
        "L_d": motor.L_d_H,
        "L_q": motor.L_q_H,
        "psi_r": motor.psi_r_Wb,
        "encoder_offset": truth.encoder_offset_rad,
        "dead_time_voltage": truth.dead_time_V,
        **{f"current_gain_{phase}": gain - 1.0 for phase, gain in zip("abc", truth.gains, strict=True)},
    }


def errors_in_uncertainties(found: FluxBalance, truth: Truth) -> list[float]:
    true = truth_of(truth)
    return [(found.solution.value(n) - true[n]) / found.solution.standard(n) for n in ESTIMATED]


def without(block: Block, **columns: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Block:
    data = np.array(block.data)
    for name, values in columns.items():
        data[:, block.names.index(name)] = values
    return replace(block, data=data)


@cache
def turning() -> Block:
    """The machine as it is believed, its speed held."""
    return capture(Truth(), Excitation(speed_rad_s=60.0), 2000)


def test_all_parameters_of_a_flawed_machine_are_found_from_a_wrong_belief() -> None:
    block = capture(FLAWED, Excitation(), 4000)
    found = flux_balance(block, EXAMPLE_MOTOR)
    true = truth_of(FLAWED)
    for name in ("R_s", "L_d", "L_q", "psi_r", "dead_time_voltage"):
        tolerance = {"R_s": 0.05, "dead_time_voltage": 0.01}.get(name, 2e-3)
        assert found.solution.value(name) == pytest.approx(true[name], rel=tolerance), name
    assert found.solution.value("encoder_offset") == pytest.approx(0.08, abs=1e-3)
    assert all(found.solution.told(name) for name in ESTIMATED)
    with_estimate, with_belief = found.error_A
    assert with_estimate < 0.015 < 2.0 * with_estimate < with_belief
    motion = motion_balance(block, EXAMPLE_MOTOR, found).solution
    assert motion.value("J") == pytest.approx(8e-4, rel=0.01)


def test_the_uncertainty_covers_the_error() -> None:
    rng, z = np.random.default_rng(7), []
    for seed in range(6):
        motor = motor_with(
            R_s_ohm=rng.uniform(0.05, 0.2), L_q_H=rng.uniform(8e-3, 15e-3), psi_r_Wb=rng.uniform(0.09, 0.12)
        )
        truth = Truth(motor, dead_time_V=rng.uniform(0.2, 2.0), encoder_offset_rad=rng.uniform(-0.1, 0.1))
        z += errors_in_uncertainties(
            flux_balance(capture(truth, Excitation(), 1500, seed), EXAMPLE_MOTOR), truth
        )
    assert 0.6 < math.sqrt(float(np.mean(np.square(z)))) < 1.5
    assert np.mean(np.abs(z) < 2.0) > 0.88


def test_noise_of_the_currents_does_not_pull_inductances_down() -> None:
    """Least squares over single ticks would: the noise of a change is as large as the change."""
    noisy = replace(FLAWED, noise_A=0.08, gains=(1.0, 1.0, 1.0), dead_time_V=0.0)
    found = flux_balance(capture(noisy, Excitation(), 4000), EXAMPLE_MOTOR).solution
    for name, true in (("L_d", 8e-3), ("L_q", 13e-3)):
        assert abs(found.value(name) - true) < 3.0 * found.standard(name) < 0.03 * true


def test_one_steady_state_does_not_tell_apart_what_takes_a_second_torque() -> None:
    block = capture(Truth(), STEADY, 2000)
    measured = FLUX_BALANCE.measure(Window.of(block, EXAMPLE_MOTOR), FluxBalanceSettings()).measurements
    reasons = {each.name.removeprefix("flux_balance_"): each.reason for each in measured}
    assert "psi_r" in reasons["R_s"]
    assert "a second torque" in reasons["R_s"]
    assert "R_s" in reasons["psi_r"]
    assert all(math.isnan(each.value) for each in measured if each.reason)


def test_a_steady_torque_between_steps_of_an_encoder_tells_no_parameter_of_the_machine() -> None:
    """Turned by an angle that comes in steps, a steady current moves along both axes: taken for excitation,
    that made R_s negative and L_d half of what it is, with a twentieth of that for U."""
    steady = Excitation(i_q_A=5.0, i_q_Hz=0.0, i_d_A=0.0, speed_rad_s=60.0)
    block = capture(Truth(counts=2500, noise_A=0.002), steady, 2000)
    found = flux_balance(replace(block, data=block.data[500:]), EXAMPLE_MOTOR).solution
    assert found.hidden == {"L_d", "L_q"}
    for name in ("R_s", "L_d", "L_q", "psi_r", "encoder_offset"):
        assert found.why_not(name)
    assert "noise hides" in found.why_not("L_d")


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (lambda b: without(b, i_b=b.column("i_c"), i_c=b.column("i_b")), "order of the phases"),
        (lambda b: without(b, theta_m=np.mod(-b.column("theta_m"), 2.0 * np.pi)), "encoder"),
        (lambda b: without(b, u_alpha=0.0 * b.column("u_alpha"), u_beta=0.0 * b.column("u_beta")), "enabled"),
        (lambda b: replace(b, stride=2), "stride = 1"),
        (lambda b: replace(b, data=b.data[:499]), "499 rows .*: record longer"),
        (lambda b: replace(b, data=b.data[:500]), "in 498 of 498 periods, .*: record an enabled drive"),
        (lambda b: replace(b, gaps=(Gap(100, 1),)), "missing"),
        (lambda b: without(b, i_a=np.clip(b.column("i_a"), -1.0, 1.0)), "clipped"),
    ],
    ids=[
        "phases swapped",
        "encoder reversed",
        "drive off",
        "every second tick",
        "short",
        "a period too short",
        "gap",
        "clipped",
    ],
)
def test_a_capture_that_cannot_answer_is_refused_with_a_remedy(change: object, seen: str) -> None:
    assert callable(change)
    with pytest.raises(AnalysisError, match=seen):
        flux_balance(change(turning()), EXAMPLE_MOTOR)


def test_wrong_pole_pairs_are_named() -> None:
    with pytest.raises(AnalysisError, match="pole pairs"):
        flux_balance(turning(), motor_with(pole_pairs=5))


def test_whitened_errors_have_the_likelihood_of_their_covariance() -> None:
    rng = np.random.default_rng(3)
    share, rows = 0.04, 30
    covariance = np.zeros((rows, rows))
    for k in range(rows):
        covariance[k, k] = 2.0 + share
        if k + 1 < rows:
            covariance[k, k + 1] = covariance[k + 1, k] = -1.0
    errors = rng.multivariate_normal(np.zeros(rows), covariance)
    filter_ = Whitening.of(np.zeros(rows, dtype=np.bool_), share)
    innovations = filter_.filtered(errors.astype(np.complex128)).real / filter_.scale
    by_filter = -0.5 * float(np.sum(innovations**2 + np.log(2.0 * np.pi * filter_.scale**2)))
    assert by_filter == pytest.approx(multivariate_normal(np.zeros(rows), covariance).logpdf(errors))


def test_a_stretch_begins_again_behind_a_period_that_is_left_out() -> None:
    left_out = np.zeros(20, dtype=np.bool_)
    left_out[9] = True
    whole, part = Whitening.of(left_out, 0.1), Whitening.of(left_out[10:], 0.1)
    assert np.isinf(whole.scale[9])
    assert whole.scale[10:] == pytest.approx(part.scale)
    assert whole.carried[10:] == pytest.approx(part.carried)


def test_the_angle_between_the_steps_of_an_encoder_is_smooth() -> None:
    t = T_S * np.arange(5000)
    angle = 3.0 * t + 2.0 * np.sin(2.0 * np.pi * 4.0 * t)
    step = 2.0 * np.pi / 10_000
    read = np.mod((np.floor(angle / step) + 0.5) * step, 2.0 * np.pi)
    smooth = smooth_angle(read)
    smooth -= 2.0 * np.pi * round(float(np.mean(smooth - angle)) / (2.0 * np.pi))
    assert np.sqrt(np.mean((smooth - angle) ** 2)) < 0.3 * step / math.sqrt(12.0)
    exact = np.sqrt(np.linspace(0.0, 9.0, 100))
    assert smooth_angle(exact) == pytest.approx(exact)


def test_an_angle_whose_levels_round_otherwise_in_each_turn_is_read_in_steps() -> None:
    angle = 20.0 + 46.0 * T_S * np.arange(4000.0) + 5.0 * np.sin(2.0 * np.pi * 5.0 * T_S * np.arange(4000.0))
    step = 2.0 * np.pi / 10_000
    read = np.mod((np.floor(angle / step) + 0.5) * step, 2.0 * np.pi)
    places = np.unique(read)
    assert np.min(np.diff(places)) < 1e-12  # one count has several values
    smooth = smooth_angle(read)
    smooth -= 2.0 * np.pi * round(float(np.mean(smooth - angle)) / (2.0 * np.pi))
    assert np.sqrt(np.mean((smooth - angle) ** 2)) < 0.6 * step / math.sqrt(12.0)


def test_a_corner_in_the_motion_does_not_set_the_smoothing_elsewhere() -> None:
    """One smoothing of the whole record would leave thirty times the error a fifth of it away."""
    t = T_S * np.arange(5000.0)
    going = 0.3 + 40.0 * np.minimum(t, 0.25) + 0.4 * np.sin(2.0 * np.pi * 4.0 * np.minimum(t, 0.25))
    on = 0.3 + 40.0 * t + 0.4 * np.sin(2.0 * np.pi * 4.0 * t)
    step, errors = 2.0 * np.pi / 10_000, []
    for angle in (going, on):
        smooth = smooth_angle(np.mod((np.floor(angle / step) + 0.5) * step, 2.0 * np.pi))
        smooth -= 2.0 * np.pi * round(float(np.mean(smooth - angle)) / (2.0 * np.pi))
        errors.append(float(np.std(np.diff(smooth - angle)[:1500])))
    assert errors[0] < 4.0 * errors[1]


def test_an_angle_that_turns_evenly_is_left_alone() -> None:
    """The smoothest curve is found of what departs from a parabola, whose size would round it off."""
    turned = 0.3 + 0.004 * np.arange(2000.0)
    smooth = smooth_angle(np.mod(turned, 2.0 * np.pi))
    assert smooth - smooth[0] == pytest.approx(turned - turned[0], abs=1e-9)


def test_the_current_bends_between_the_ticks_of_a_rotor_that_turns_far() -> None:
    """By the straight line between its ends the drop of resistance would err by a thousandth of a volt."""
    p = Electrical(2.0, 1e-3, 2e-3, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    omega, begin, flux, u_s = 1500.0, 0.3, 0.12 + 0.01j, 20.0 + 140.0j
    rotor = np.exp(1j * (begin + omega * T_S * np.linspace(0.0, 1.0, 2001)))

    def current(psi_s: complex, direction: complex) -> complex:
        return complex(current_of(np.array([psi_s * np.conj(direction)]), p)[0] * direction)

    fluxes = [flux * rotor[0]]
    for direction, after in itertools.pairwise(rotor):  # by the rule of the middle, with steps of 50 ns
        half = fluxes[-1] + 0.5 * T_S / 2000 * (u_s - p.R_s * current(fluxes[-1], direction))
        middle = current(half, np.sqrt(direction * after))
        fluxes.append(fluxes[-1] + T_S / 2000 * (u_s - p.R_s * middle))
    ends = [current(fluxes[k], rotor[k]) for k in (0, -1)]
    columns = space_columns(np.array(ends), np.angle(rotor[[0, -1]]), u_s)
    ticks = Ticks.of(columns, 1, 0)
    error_V = abs(complex(ticks.errors(p, np.zeros(1, dtype=np.complex128))[0])) / T_S
    between = [current(*each) for each in zip(fluxes, rotor, strict=True)]
    by_line_V = abs(p.R_s * (0.5 * sum(ends) - np.mean(between)))
    assert error_V < 0.02 * by_line_V
    assert by_line_V > 1e-3


def test_the_error_of_a_prediction_is_that_in_both_axes_of_a_salient_machine() -> None:
    """Noise of a phase of rms s is in both ends of a tick, in both axes, whatever their inductances are."""
    salient = Truth(motor_with(L_d_H=5e-3, L_q_H=15e-3), noise_A=0.05, step_A=1e-6)
    found = flux_balance(capture(salient, Excitation(speed_rad_s=60.0), 3000), EXAMPLE_MOTOR)
    assert found.error_A[0] == pytest.approx(math.sqrt(8.0 / 3.0) * 0.05, rel=0.04)


def test_errors_that_outlast_a_block_are_in_the_covariance() -> None:
    """A line through noise with a memory of 300 rows, in blocks of a hundred rows."""
    rng, rows = np.random.default_rng(5), 12_000
    line = np.stack([np.ones(rows), np.linspace(-1.0, 1.0, rows)], axis=1)
    zero, spans, z = np.zeros(2), np.full(2, 1e3), []
    for _ in range(40):
        steps = rng.standard_normal(rows + 3000)
        noise = signal.lfilter([1.0], [1.0, -math.exp(-1.0 / 300.0)], steps)[3000:]
        found = solve(("level", "slope"), line, noise, zero, zero, spans)
        z.append(found.values / np.sqrt(np.diag(found.covariance)))
    assert 0.75 < math.sqrt(float(np.mean(np.square(z)))) < 1.3


def test_the_error_of_a_prediction_in_noise_of_heavy_tails_is_known_as_its_squares_scatter() -> None:
    block, rng = capture(Truth(noise_A=0.0), Excitation(speed_rad_s=60.0), 3000), np.random.default_rng(8)
    clicks = {
        name: block.column(name) + 0.02 * rng.standard_t(2.5, len(block.data))
        for name in ("i_a", "i_b", "i_c")
    }
    window = Window.of(without(block, **clicks), EXAMPLE_MOTOR)
    found = {e.name: e for e in FLUX_BALANCE.measure(window, FluxBalanceSettings()).measurements}
    error = found["flux_balance_error_rms"]
    assert error.uncertainty is not None
    assert error.uncertainty.standard > 1.5 * error.value / math.sqrt(2.0 * 3000)


@cache
def balanced() -> FluxBalance:
    return flux_balance(turning(), EXAMPLE_MOTOR)


def test_numbers_of_a_capture_are_those_of_its_vectors() -> None:
    found, block = balanced(), turning()
    a, b, c = (block.column(name) for name in ("i_a", "i_b", "i_c"))
    assert found.omega_e_rad_s == pytest.approx(4 * 60.0, rel=1e-4)
    assert found.current_A == pytest.approx(np.sqrt(2.0 / 3.0 * np.mean(a**2 + b**2 + c**2)), rel=1e-3)
    backwards = replace(found, ticks=replace(found.ticks, rotor=np.conj(found.ticks.rotor)))
    assert backwards.omega_e_rad_s == found.omega_e_rad_s
    # of three phases: the torque is the power of the back-EMF over the speed
    salient = found.estimate._replace(L_d=5e-3, L_q=8e-3, psi_r=0.09, encoder_offset=0.2)
    i_dq = found.ticks.measured_dq * np.exp(-0.2j)
    torque = 1.5 * 4 * (0.09 + (5e-3 - 8e-3) * i_dq.real) * i_dq.imag
    no_gains = salient._replace(current_gain_a=0.0, current_gain_b=0.0)
    assert found.torque(no_gains, 4) == pytest.approx(torque)
    assert len(found.squares_A2) == len(found.left_out) - np.count_nonzero(found.left_out)


def test_what_a_capture_does_not_tell_is_as_it_was_believed() -> None:
    belief = motor_with(R_s_ohm=0.15)
    found = flux_balance(capture(Truth(), STEADY, 1000), belief)
    assert not found.solution.told("R_s")
    assert found.solution.told("dead_time_voltage") or found.estimate.dead_time_voltage == 0.0
    assert found.estimate.R_s == 0.15
    assert balanced().estimate.R_s == balanced().solution.value("R_s")
    assert sum(found.solution.value(f"current_gain_{phase}") for phase in "abc") == pytest.approx(
        0.0, abs=1e-12
    )


def test_unknowns_are_as_large_as_a_machine_of_this_rating_may_have_them() -> None:
    """A twenty-fifth of the dc link for a voltage, and a thousandth of that for the drop of a resistance."""
    found, voltage = balanced(), 0.04 * 100.0
    expected = [0.1, 1e-2, 1e-2, 0.1, 0.4, voltage, 0.2, 0.2, voltage, voltage, 0.2]
    assert found.solution.spans == pytest.approx(expected)
    salient = flux_balance(turning(), motor_with(R_s_ohm=1e-9, L_d_H=8e-3, L_q_H=12e-3))
    phases = np.stack([turning().column(name) for name in ("i_a", "i_b", "i_c")])
    least = 1e-3 * voltage / np.sqrt(np.mean(phases**2))
    assert salient.solution.spans[:3] == pytest.approx([least, 8e-3, 12e-3], rel=1e-3)


@pytest.mark.parametrize("dead_time_V", [1.5, -1.0])
def test_signs_are_unsure_within_two_steps_and_what_two_dead_times_do(
    dead_time_V: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits, signs = [], Edges.signs

    def seen(edges: Edges, i_s: Complex, L: float, least_A: float, shortest_s: float) -> object:
        limits.append((L, least_A, shortest_s))
        return signs(edges, i_s, L, least_A, shortest_s)

    monkeypatch.setattr(Edges, "signs", seen)
    belief = motor_with(L_d_H=8e-3)
    block = turning()
    signs_abc = np.sign([np.roll(block.column(name), -1) for name in ("i_a", "i_b", "i_c")])
    asked = block.column("u_alpha") + 1j * block.column("u_beta") + dead_time_V * space_vector(signs_abc)
    p = flux_balance(without(block, u_alpha=asked.real, u_beta=asked.imag), belief).estimate
    assert limits[0] == pytest.approx((9e-3, 2.0 * 0.01, 0.0))
    assert p.dead_time_voltage == pytest.approx(dead_time_V, rel=0.1)  # or as much too much compensated
    L, lost_Vs = 0.5 * (p.L_d + p.L_q), 2.0 * abs(p.dead_time_voltage) * T_S
    expected = (L, 0.02 + lost_Vs / L, lost_Vs / 100.0)
    assert any(each == pytest.approx(expected, rel=1e-6) for each in limits)


def test_the_gain_of_a_phase_is_minus_those_of_the_others() -> None:
    found = balanced().solution
    a, b, c = (found.names.index(f"current_gain_{phase}") for phase in "abc")
    assert found.values[c] == -found.values[a] - found.values[b]
    for covariance in (found.covariance, found.certain):
        of_both = covariance[a, a] + covariance[b, b] + 2.0 * covariance[a, b]
        assert covariance[c, c] == pytest.approx(of_both)
        assert covariance[c, 0] == pytest.approx(-covariance[a, 0] - covariance[b, 0])
    assert found.bias[c] == math.hypot(found.bias[a], found.bias[b])


@pytest.mark.parametrize("scale", [1.2, 0.85])
def test_what_more_noise_moves_is_a_bias(scale: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Currents that are so many times as large in place of noise: resistance and inductances are smaller or
    larger by as much, the flux of the rotor is as it is."""
    added = []

    def larger(ticks: Ticks, rms_A: float) -> Ticks:
        added.append(rms_A)
        return replace(ticks, phases=scale * ticks.phases)

    monkeypatch.setattr(Ticks, "with_noise", larger)
    noisy = capture(Truth(noise_A=0.05, step_A=1e-6), Excitation(speed_rad_s=60.0), 1500)
    found = flux_balance(noisy, EXAMPLE_MOTOR).solution
    assert added == pytest.approx([0.05], rel=0.05)
    for place, name in enumerate(("R_s", "L_d", "L_q", "psi_r")):
        moved = 0.0 if name == "psi_r" else abs(1.0 / scale - 1.0) * found.value(name)
        scatter = math.sqrt(found.covariance[place, place])
        assert found.bias[place] == pytest.approx(max(0.0, moved - 2.0 * scatter), rel=0.1, abs=0.3 * scatter)


@pytest.mark.parametrize(
    ("rows", "driven", "is_refused"), [(1200, 520, True), (2400, 900, False), (8000, 1300, True)]
)
def test_a_balance_needs_five_hundred_periods_and_a_sixth_of_all(
    rows: int, driven: int, is_refused: bool
) -> None:
    """Those with a voltage, less some in which a phase current is close to zero."""
    block = turning()
    data = np.tile(block.data, (rows // len(block.data) + 1, 1))[:rows]
    data[driven:, [block.names.index(name) for name in ("u_alpha", "u_beta")]] = 0.0
    part = replace(block, data=data)
    if is_refused:
        with pytest.raises(AnalysisError, match="close to zero"):
            flux_balance(part, EXAMPLE_MOTOR)
    else:
        assert 500 < len(flux_balance(part, EXAMPLE_MOTOR).squares_A2) < driven


@pytest.mark.parametrize(("part", "is_refused"), [(0.02, False), (0.06, True)])
def test_a_voltage_that_no_parameters_explain_is_told(part: float, is_refused: bool) -> None:
    """So much of it more and less in turn, for a twentieth of a second each."""
    block = turning()
    more = 1.0 + part * np.where(np.arange(2000) // 250 % 2, 1.0, -1.0)
    uneven = without(block, u_alpha=more * block.column("u_alpha"), u_beta=more * block.column("u_beta"))
    if is_refused:
        with pytest.raises(AnalysisError, match=r"% of the voltage are not explained"):
            flux_balance(uneven, EXAMPLE_MOTOR)
        return
    rms_V = math.sqrt(float(np.mean(np.abs(block.column("u_alpha")) ** 2 + block.column("u_beta") ** 2)))
    assert flux_balance(uneven, EXAMPLE_MOTOR).unexplained_V == pytest.approx(part * rms_V, rel=0.2)
    assert balanced().unexplained_V < 0.1 * part * rms_V


@pytest.mark.parametrize(("share", "is_refused"), [(0.14, True), (0.3, False)])
def test_a_rotor_without_the_flux_that_is_believed_is_refused(share: float, is_refused: bool) -> None:
    belief = motor_with(psi_r_Wb=0.1 / share)
    if is_refused:
        with pytest.raises(AnalysisError, match="no rotor flux turns"):
            flux_balance(turning(), belief)
    else:
        assert flux_balance(turning(), belief).solution.value("psi_r") == pytest.approx(0.1, rel=0.01)


@pytest.mark.parametrize("times", [0.2, 6.0])
def test_a_belief_that_is_far_off_is_left_in_steps(times: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of no more than half, until what moves is a fiftieth of the uncertainty: once with the noise that is
    there, and once with more."""
    runs: dict[tuple[float, ...], list[tuple[Floats, Solution]]] = {}

    def seen(names: tuple[str, ...], *arrays: Floats) -> Solution:
        _, _, start, belief, _ = arrays
        runs.setdefault(tuple(belief), []).append((start, solve(names, *arrays)))
        return runs[tuple(belief)][-1][1]

    monkeypatch.setattr(sys.modules[FluxBalance.__module__], "solve", seen)
    believed = motor_with(L_d_H=times * 1e-2, L_q_H=times * 1e-2, psi_r_Wb=0.15)
    found = flux_balance(turning(), believed).solution
    first, noisy = runs.values()
    starts = np.array([start[1:4] for start, _ in first])
    steps = starts[1:] / starts[:-1]
    assert np.min(steps[:, :2]) == pytest.approx(0.5) if times > 1.0 else np.max(steps) == pytest.approx(1.5)
    assert np.all((steps > 0.499) & (steps < 1.501))
    for run, searches in ((first, 4), (noisy, 0)):
        moved = [
            np.max(np.abs(later.values - each.values) / np.sqrt(np.diag(later.covariance)))
            for (_, each), (_, later) in itertools.pairwise(run)
        ]
        assert moved[-1] < 0.02
        assert all(each > 0.02 for each in moved[max(0, searches - 1) : -1])
    for name, true in (("L_d", 1e-2), ("L_q", 1e-2), ("psi_r", 0.1)):
        assert found.value(name) == pytest.approx(true, rel=0.01), name
