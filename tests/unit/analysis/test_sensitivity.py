"""Declared sensitivities against the derivative of each measurement of the catalogue."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache

import pytest

from benchtool.analysis import Measurement
from benchtool.analysis.catalogue import catalogue
from benchtool.analysis.sensitivity import Component
from benchtool.analysis.sensors.instruments import Instruments, Perturbed
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.profile import Bench, ReferenceClock
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, steady_capture

STEADY = catalogue().steady
CHANNELS = sorted({name for each in STEADY for name in each.channels} - {"theta_m", "switching_count"})
STEP = 1e-6

Numbers = Mapping[str, Measurement]


@cache
def _raised() -> tuple[Block, Block]:
    """The specimen with a transducer that reads otherwise than the estimate: no mean is like another."""
    block, transducer = steady_capture()
    return block, Perturbed("torque_transducer", 0.1, 0.2).of(transducer)


def _values(block: Block, transducer: Block, of: str = "") -> Numbers:
    """All measurements, or those of the analyses that read one channel."""
    window = Window.of(block, EXAMPLE_MOTOR, transducer)
    found: dict[str, Measurement] = {}
    for analysis in STEADY:
        reads = (*analysis.channels, *(("torque_transducer",) if analysis.transducer else ()))
        if not of or of in reads:
            found |= {each.name: each for each in analysis.measure(window, analysis.settings()).measurements}
    return found


@cache
def _base() -> Numbers:
    return _values(*_raised())


@cache
def _altered(altered: Perturbed) -> Numbers:
    block, transducer = _raised()
    again = _values(altered.of(block), altered.of(transducer), altered.channel)
    return {**_base(), **again}


def _perturbed(channel: str, error: str, by: float) -> Perturbed:
    return Perturbed(channel, gain=by) if error == "gain" else Perturbed(channel, offset=by)


def _derivative(name: str, channel: str, error: str) -> float:
    up, down = (_altered(_perturbed(channel, error, step)) for step in (STEP, -STEP))
    return (up[name].value - down[name].value) / (2.0 * STEP)


def _stated(of: Measurement, channel: str, error: str) -> float:
    return sum(
        each.gain if error == "gain" else each.offset
        for each in of.sensitivities.channels or ()
        if each.channel == channel
    )


@pytest.mark.parametrize("error", ["gain", "offset"])
@pytest.mark.parametrize("channel", [*CHANNELS, "torque_transducer"])
def test_each_declaration_is_the_derivative_of_its_measurement(channel: str, error: str) -> None:
    """Of each measurement of a steady state by each channel, those that are not declared excepted."""
    compared = 0
    for name, each in _base().items():
        if not each.sensitivities.is_declared or not math.isfinite(each.value):
            continue
        stated = _stated(each, channel, error)
        if isinstance(each.sensitivities.content, Component):
            up = _altered(_perturbed(channel, error, 0.01))[name].value - each.value
            assert abs(up) <= 0.0101 * stated + 1e-12, name
            # and no more than it takes: near zero all of it moves a magnitude
            assert abs(up) >= 0.0095 * stated, name
            continue
        assert _derivative(name, channel, error) == pytest.approx(
            stated, rel=2e-3, abs=2e-4 * max(1e-3, abs(each.value))
        ), name
        compared += 1
    assert compared > 30


def test_only_these_are_measured_again() -> None:
    """A new analysis may be; none that has declared its sensitivities falls back to it."""
    found = _base()
    declared = {
        analysis.name: {
            found[name].sensitivities.is_declared
            for name in analysis.names
            if name in found and math.isfinite(found[name].value)
        }
        for analysis in STEADY
    }
    again = {name for name, each in declared.items() if False in each}
    known = {"flux_trajectory", "switching_states", "torque_residual", "transducer_torque_residual"}
    assert known <= again
    assert again.isdisjoint(
        {
            *("torque_ripple", "transducer_torque_ripple", "torque_error", "flux_ripple", "current_spectrum"),
            *("switching_frequency", "torque_orders", "speed_orders", "torque_spectrum", "current_unbalance"),
        }
    )
    assert all(len(each) <= 1 for each in declared.values())


def test_the_clock_moves_times_and_frequencies_by_their_unit() -> None:
    block, transducer = _raised()
    tolerance_ppm = 30.0
    bench = Bench(clock=ReferenceClock(tolerance_ppm=tolerance_ppm))

    def slower(by: float) -> Iterator[Measurement]:
        window = Window.of(
            replace(block, tick_s=block.tick_s * (1.0 + by)),
            EXAMPLE_MOTOR,
            replace(transducer, tick_s=transducer.tick_s * (1.0 + by)),
        )
        for analysis in STEADY:
            yield from analysis.measure(window, analysis.settings()).measurements

    found = list(slower(0.0))
    by_name = {each.name: each for each in Instruments(bench).applied(found)}
    up, down = ({each.name: each.value for each in slower(by)} for by in (STEP, -STEP))
    moved = 0
    for each in found:
        if not each.sensitivities.is_declared or each.uncertainty is None:
            continue
        derivative = (up[each.name] - down[each.name]) / (2.0 * STEP)
        after = by_name[each.name].uncertainty
        assert after is not None
        lines = [line for line in after.budget if line.instrument is not None]
        stated = sum(line.sign * line.standard for line in lines) / (1e-6 * tolerance_ppm / math.sqrt(3.0))
        assert stated == pytest.approx(derivative, rel=2e-3, abs=2e-4 * abs(each.value)), each.name
        moved += bool(lines)
    assert moved >= 3
