"""What sensors and their steps do to the numbers of balances."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchtool.analysis import Instruments, Measurement, Perturbed, Window
from benchtool.analysis.balances.deviations import deviations
from benchtool.analysis.balances.flux_measurements import FLUX_BALANCE, FluxBalanceSettings
from benchtool.analysis.balances.motion_balance import MOTION_BALANCE, MotionBalanceSettings
from benchtool.analysis.balances.readings import of_readings
from benchtool.analysis.sensitivity import Error
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.block import Block, Channel
from benchtool.profile import Bench, Sensor
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.excited_machine import U_DC, excited_capture

STEP_V = 0.5
BY_LINK = {
    *(f"flux_balance_{name}" for name in ("R_s", "L_d", "L_q", "psi_r", "dead_time_voltage")),
    *(f"motion_balance_{name}" for name in ("J", "friction", "coulomb")),
}


def balances(block: Block) -> Iterator[Measurement]:
    window = Window.of(block, EXAMPLE_MOTOR)
    yield from FLUX_BALANCE.measure(window, FluxBalanceSettings()).measurements
    yield from MOTION_BALANCE.measure(window, MotionBalanceSettings()).measurements


@cache
def of_a_still_link() -> Mapping[str, Measurement]:
    """Each number by its name, of a dc link that reads the same in every sample."""
    return {each.name: each for each in balances(excited_capture())}


def with_link(readings_V: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Block:
    """Return the capture of a dc link that was read so, whose voltages the drive made by that."""
    block = excited_capture()
    data = np.array(block.data)
    data[:, block.names.index("u_dc")] = readings_V
    for name in ("u_alpha", "u_beta"):
        data[:, block.names.index(name)] *= readings_V / U_DC
    return replace(block, data=data)


def applied(channel: str, block: Block | None = None, **stated: float) -> Mapping[str, Measurement]:
    """Return the numbers of a capture with a stated sensor."""
    block = block or excited_capture()
    bench = Bench(channels={channel: Sensor.model_validate(stated)})
    read = of_a_still_link().values() if block is excited_capture() else balances(block)
    found = Instruments(bench, [block]).applied(list(read), lambda altered: balances(altered.of(block)))
    return {each.name: each for each in found}


def known(of: Measurement) -> Uncertainty:
    assert of.known_uncertainty is not None
    return of.known_uncertainty


def test_a_link_that_reads_the_same_in_every_sample_leaves_open_what_scales_with_it() -> None:
    found = of_a_still_link()
    told = {name for name, each in found.items() if math.isfinite(each.value)}
    unknown = {name for name in told if found[name].uncertainty is None}
    assert unknown == BY_LINK & told
    assert {"flux_balance_psi_r", "motion_balance_J"} <= unknown
    for name in unknown:
        assert "state resolution_V in [bench.channels.u_dc] of the profile" in found[name].uncertainty_reason
        assert known(found[name]).standard > 0.0


def test_a_stated_resolution_is_the_one_of_such_a_link() -> None:
    found = applied("u_dc", resolution_V=STEP_V)
    for name in ("flux_balance_psi_r", "motion_balance_J"):
        each, beside = found[name], known(of_a_still_link()[name]).standard
        assert not each.uncertainty_reason
        assert each.uncertainty is not None
        by_step = STEP_V / math.sqrt(12.0) / U_DC * each.value
        assert each.uncertainty.standard == pytest.approx(math.hypot(beside, by_step), rel=0.02)
        assert by_step > 2.0 * beside
    angle = found["flux_balance_encoder_offset"]
    assert angle.uncertainty == of_a_still_link()["flux_balance_encoder_offset"].uncertainty


def test_an_offset_of_the_link_scales_as_its_part_of_it_does() -> None:
    found = applied("u_dc", resolution_V=1e-6, offset_U_V=1.0)["flux_balance_psi_r"]
    beside = known(of_a_still_link()["flux_balance_psi_r"]).standard
    assert known(found).standard == pytest.approx(math.hypot(beside, 0.5 / U_DC * found.value), rel=1e-3)


def test_a_gain_alone_does_not_tell_the_resolution() -> None:
    found = applied("u_dc", gain_limit_percent=0.5)["flux_balance_psi_r"]
    assert found.uncertainty is None
    assert any(math.isnan(line.standard) for line in found.of_sensors)


def test_steps_that_the_link_shows_enter_once() -> None:
    """Of noise a tenth of a step half way between two levels the mean is near the truth, of a value that is
    read on the other level in one of thirty samples it is half of a step off."""
    random = np.random.default_rng(2)
    rows = len(excited_capture().data)
    read_V = U_DC + np.where(random.random(rows) < 1.0 / 30.0, STEP_V, 0.0)
    block = with_link(read_V)
    seen = {each.name: each for each in balances(block)}["flux_balance_psi_r"]
    assert seen.uncertainty is not None
    (line,) = (line for line in seen.uncertainty.budget if line.name == "resolution of u_dc")
    assert line.evaluation == "B"
    assert 0.2 * STEP_V < line.standard / seen.value * U_DC < 0.45 * STEP_V
    stated = applied("u_dc", block, resolution_V=STEP_V)["flux_balance_psi_r"]
    assert stated.uncertainty is not None
    assert stated.uncertainty.standard == pytest.approx(seen.uncertainty.standard)


def test_an_offset_of_a_current_sensor_is_measured_again() -> None:
    """It swings the torque by the angle of the shaft, and comes out as inertia."""
    offset_A = 0.03
    found = applied("i_a", offset_U_A=2.0 * offset_A)["motion_balance_J"]
    moved = Perturbed("i_a", offset=offset_A).of(excited_capture())
    again = {each.name: each for each in balances(moved)}["motion_balance_J"]
    (line,) = (line for line in found.of_sensors if "offset" in line.name)
    assert line.standard >= abs(again.value - found.value) > 0.0


def test_a_rotor_flux_that_is_believed_does_not_come_from_the_link() -> None:
    sensed = of_readings(1e-3, None, 1)
    assert sensed.named == ("i_a", "i_b", "i_c", "theta_m")
    assert sum(each.gain for each in sensed.channels or ()) == pytest.approx(1e-3)
    assert Error.GAIN not in sensed.again("i_a")


def test_a_belief_is_contradicted_by_what_is_known_beside_the_resolution() -> None:
    psi_r = of_a_still_link()["flux_balance_psi_r"]
    (beside,) = deviations([psi_r], {"psi_r": 0.5}, EXAMPLE_MOTOR, U_DC)
    assert beside.contradicts
    wide = replace(psi_r, uncertainty=Uncertainty(1.0, "")).without_resolution_of(Channel("u_dc", "V"))
    (beside,) = deviations([wide], {"psi_r": 0.5}, EXAMPLE_MOTOR, U_DC)
    assert not beside.contradicts
