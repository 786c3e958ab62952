"""The encoder against a disc with two tracks and an index, whose edges a counter walks through one by one."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.core.kernels import kernel_of
from benchtool.emulator.machine.encoder import encoder_count
from benchtool.emulator.machine.sensor_truth import CurrentTruth, EncoderTruth
from benchtool.emulator.memory import SENSOR
from tests.physics.paper_machine import FINE, captured, make_core

LINES = 16
_ORDER = [(True, True), (False, True), (False, False), (True, False)]  # of (A, B), as the disc turns up


class Disc:
    """Tracks A and B, half a line apart by a quarter, an index, and the counter of a drive."""

    def __init__(self, flaws: EncoderTruth, zero: float, theta: float) -> None:
        self.flaws, self.zero = flaws, zero
        self.count = self.passed = 0
        self.tracks, self.turn = self.signals(theta)
        if not flaws.relative:
            turned = self.position(theta) / (2.0 * math.pi)
            self.count = math.floor((turned - math.floor(turned)) * 4 * LINES)

    def position(self, theta: float) -> float:
        flaws = self.flaws
        disc = theta - flaws.slip * theta + self.zero
        lines = disc + (
            flaws.eccentricity_1_rad * math.sin(disc + flaws.eccentricity_1_phase_rad)
            + flaws.eccentricity_2_rad * math.sin(disc + disc + flaws.eccentricity_2_phase_rad)
        )
        return -lines if flaws.reversed else lines

    def signals(self, theta: float) -> tuple[tuple[bool, bool], int]:
        at = self.position(theta)
        tracks = (math.cos(LINES * at) >= 0.0, math.sin(LINES * at) >= 0.0)
        return tracks, math.floor(at / (2.0 * math.pi))

    def move(self, theta: float) -> None:
        """Follow the signals over less than an edge."""
        tracks, turn = self.signals(theta)
        steps = (_ORDER.index(tracks) - _ORDER.index(self.tracks) + 1) % 4 - 1
        assert steps in (-1, 0, 1), "the walk is too coarse"
        if steps:
            self.passed += 1
            lost = self.flaws.lost_every and self.passed % self.flaws.lost_every == 0
            self.count += 0 if lost else steps
        if self.flaws.index and turn != self.turn:
            self.count = 0 if turn > self.turn else -1
        self.tracks, self.turn = tracks, turn


def path(seed: int) -> NDArray[np.float64]:
    """Shaft angles at the ticks: up, down, some revolutions, with many edges or none in a tick."""
    generator = np.random.default_rng(seed)
    speeds = np.repeat(generator.uniform(-1.5, 1.5, 25), 8)
    return np.cumsum(np.concatenate([[generator.uniform(-20.0, 20.0)], speeds]))


@pytest.mark.parametrize(
    "flaws",
    [
        {},
        {"reversed": True},
        {"relative": True},
        {"relative": True, "index": True},
        {"relative": True, "index": True, "reversed": True},
        {"lost_every": 7},
        {"lost_every": 5, "index": True},
        {"lost_every": 2},
        {"eccentricity_1_rad": 0.1, "eccentricity_1_phase_rad": 0.7},
        {"eccentricity_2_rad": 0.05, "eccentricity_2_phase_rad": -0.4, "reversed": True},
        {"slip": 0.03, "relative": True, "index": True, "lost_every": 11, "eccentricity_1_rad": 0.2},
    ],
    ids=lambda flaws: " ".join(flaws) or "ideal",
)
def test_counts_are_those_of_a_walk_through_the_edges(flaws: dict[str, Any]) -> None:
    truth, zero = EncoderTruth(**flaws), 0.3
    angles = path(seed=len(flaws))
    encoder, sensor = truth.encoder(LINES, zero), np.zeros(1, SENSOR)[0]
    disc = Disc(truth, zero, angles[0])
    got, walked = [encoder_count(angles[0], encoder, sensor)], [disc.count % (4 * LINES)]
    for start, end in itertools.pairwise(angles):
        for theta in np.linspace(start, end, 60)[1:]:
            disc.move(theta)
        got.append(encoder_count(end, encoder, sensor))
        walked.append(disc.count % (4 * LINES))
    assert got == walked
    assert len(set(got)) > LINES


def test_an_unknown_angle_at_power_up_is_known_once_the_index_has_passed() -> None:
    """Until then the drive's angle is wrong by the shaft's at power-up, and again after a reset."""
    core = make_core(
        motor={"power_up_angle_rad": 1.0},
        inverter={"u_dc_V": 300.0},  # above the line EMF
        sensors={**FINE, "encoder": EncoderTruth(relative=True, index=True)},
    )
    core.load.held, core.load.omega_m_rad_s = 1, 200.0
    core.memory["omega_m_trip"] = 1e3

    def error() -> float:
        true = float(core.shaft.theta_e) / core.motor.pole_pairs
        off = float(core.memory["theta_m"][0]) - true
        return (off + math.pi) % (2.0 * math.pi) - math.pi

    core.run_with(run_ticks, 10)
    assert error() == pytest.approx(-1.0 - 200.0 * 1e-4, abs=1e-6)  # the first count is at the first tick
    core.run_with(run_ticks, 260)  # to 6.4 rad
    assert error() == pytest.approx(0.0, abs=1e-6)
    core.restart_counter()
    core.run_with(run_ticks, 10)
    assert abs(error()) == pytest.approx((1.0 + 271 * 0.02) % (2.0 * math.pi), abs=1e-6)


def test_sensors_change_in_the_course_of_a_run_without_another_kernel() -> None:
    """Stuck, cut off, slipping and sound again: nothing but numbers, from one tick to the next."""
    core = make_core(sensors=FINE)
    core.load.held, core.load.omega_m_rad_s = 1, 30.0
    kernel, sound = kernel_of(core._truth), core.sensors
    step: float = 2.0 * math.pi / (4 * FINE["encoder_lines"])

    def shown() -> float:
        return float(core._measurements[0].count) * step

    def true() -> float:
        return float(core.shaft.theta_e) / core.motor.pole_pairs

    core.run(100)
    core.set_sensors(replace(sound, i_a=CurrentTruth(stuck_A=2.5)))
    assert captured(core, ["i_a", "i_b"], 20)["i_a"] == pytest.approx(2.5, abs=1e-5)

    core.set_sensors(replace(sound, i_b=CurrentTruth(noise_A_rms=0.2)))
    noisy = captured(core, ["i_a", "i_b"], 4000)
    assert noisy["i_b"].std() == pytest.approx(0.2, rel=0.1)
    assert not noisy["i_a"].any()

    core.set_sensors(replace(sound, encoder=EncoderTruth(slip=0.01)))
    began = true()
    core.run(1000)
    behind = 0.01 * (true() - began)
    assert (true() - shown()) % (2 * math.pi) == pytest.approx(behind, abs=2 * step)

    core.set_sensors(replace(sound, encoder=EncoderTruth(stuck=True)))
    last = shown()
    core.run(100)
    assert shown() == pytest.approx(last, abs=2 * step)

    core.set_sensors(sound)
    turned = true()
    core.run(100)
    assert shown() - last == pytest.approx(true() - turned, abs=2 * step)
    assert kernel_of(core._truth) is kernel
