"""Whether the fundamental is a reference: one regime, on a phase, out of the noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import CoherentSamples, current_spectrum, track_angle
from benchtool.analysis.phase.wander import Wander
from benchtool.analysis.spectra.separation import separate
from benchtool.analysis.spectra.soundness import soundness, turned_around
from benchtool.block import Block
from tests.unit.analysis.noise.lines_in_noise import spectrum_of_bins

Floats = NDArray[np.float64]
_PERIODS, _PER_PERIOD = 40, 48
_STEADY = Wander(np.zeros(_PERIODS), np.ones(_PERIODS), 0.0, 1e-3)


def _reasons(
    fundamental: float, noise: float, beside: float = 0.0, seen: Wander = _STEADY, invalid: str = ""
) -> tuple[str, str]:
    """Return why amplitudes and ratios are not defined, of a fundamental in even noise that only moves its
    phase, with eight pairs of sidebands besides that only change its amplitude."""
    phasor = np.full(_PERIODS * 12, 1j * noise)
    phasor[_PERIODS - 8 : _PERIODS + 9] += beside
    phasor[_PERIODS] = fundamental
    found = soundness(spectrum_of_bins(phasor, _PERIODS), seen, invalid, "i_a")
    return found.of_amplitudes, found.of_ratios


def test_a_steady_fundamental_is_a_reference() -> None:
    assert _reasons(1.0, 1e-3) == ("", "")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"excess_rad": 0.11}, "phase of i_a wanders by 0.11 rad"),
        ({"jump_rad": 0.5}, "jumps by 0.5 rad from one period to the next: it reversed"),
        ({"jump_rad": 0.5, "jumps_alone": True}, "rows are missing or repeat others"),
        (
            {"jump_rad": 0.5, "jumps_alone": True, "by_angle": True},
            "the encoder, its coupling or belt slipped",
        ),
        ({"amplitude": np.repeat([1.0, 1.3], 20)}, "the amplitude of i_a changes from 1 to 1.3"),
    ],
)
def test_two_regimes_leave_neither_amplitudes_nor_ratios(changes: dict[str, object], words: str) -> None:
    seen = replace(_STEADY, **changes)  # type: ignore[arg-type]
    of_amplitudes, of_ratios = _reasons(1.0, 1e-3, seen=seen)
    assert words in of_amplitudes
    assert of_ratios == of_amplitudes
    for fundamental in (0.0, 1e-3):
        assert _reasons(fundamental, 1e-3, seen=seen)[1] == of_amplitudes
        assert _reasons(fundamental, 1e-3, seen=seen, invalid="it is clipped") == ("it is clipped",) * 2


def test_a_phase_that_wanders_little_is_a_phase() -> None:
    assert _reasons(1.0, 1e-3, seen=replace(_STEADY, excess_rad=0.09)) == ("", "")


def test_a_fundamental_of_nothing_has_an_amplitude_and_no_ratio() -> None:
    assert _reasons(0.0, 1e-3) == ("", "the fundamental is zero")


@pytest.mark.parametrize(
    ("noise", "beside", "least"),
    [
        (1.0, 0.0, 4.0 / np.sqrt(np.log(2.0))),  # four times the rms of bins, by their median
        (1e-6, 1.0, 5.0 / np.sqrt(1 / 5 + 1 / 6 + 1 / 7 + 1 / 8 + 1 / 8)),  # five times that of eight pairs
    ],
)
def test_a_fundamental_stands_out_of_noise_or_has_no_ratio(noise: float, beside: float, least: float) -> None:
    assert _reasons(1.02 * least, noise, beside) == ("", "")
    of_amplitudes, of_ratios = _reasons(0.98 * least, noise, beside)
    assert of_amplitudes == ""
    assert "does not stand out of the noise" in of_ratios


def _samples(
    harmonics: dict[int, Floats | float],
    phase_rad: Floats | float = 0.0,
    noise: float = 0.0,
    periods: int = 40,
    per_period: int = _PER_PERIOD,
) -> CoherentSamples:
    """Return a fundamental of 1 and harmonics of these sizes in each period, all turned by a phase."""
    turn = 2.0 * np.pi * np.arange(per_period) / per_period
    turned = turn + np.broadcast_to(phase_rad, periods)[:, np.newaxis]
    table = np.cos(turned)
    for order, size in harmonics.items():
        table = table + np.broadcast_to(size, periods)[:, np.newaxis] * np.cos(order * turned + 0.3 * order)
    values = table.ravel() + noise * np.random.default_rng(2).standard_normal(table.size)
    return CoherentSamples(values, periods, float(table.size), 10e3)


_FLIPS = np.repeat([1.0, -1.0], 20)


@pytest.mark.parametrize(
    ("harmonics", "named"),
    [
        ({3: 0.2 * _FLIPS, 5: 0.1}, 3),
        ({3: 0.2, 5: 0.1 * _FLIPS}, 5),
        ({2: 0.2 * _FLIPS}, 2),
        ({13: 0.2 * _FLIPS}, 13),
        ({14: 0.2 * _FLIPS}, None),  # beyond those that are looked at
        ({3: 0.2, 5: 0.15, 7: 0.1 * _FLIPS}, None),  # of the two strongest alone
        ({3: 0.2, 5: 0.1}, None),
        ({3: 0.2 * (1.0 + 0.22 * _FLIPS)}, None),  # of less than half of its mean
        ({3: 0.2 * (1.0 + 0.28 * _FLIPS)}, 3),
    ],
)
def test_a_harmonic_that_turns_against_the_fundamental_is_of_two_regimes(
    harmonics: dict[int, Floats | float], named: int | None
) -> None:
    phase_rad = np.cumsum(0.05 * np.random.default_rng(1).standard_normal(40))
    seen = replace(_STEADY, phase_rad=np.append(phase_rad, [1.0, 2.0]))
    reason = turned_around(_samples(harmonics, phase_rad), seen, "i_a")
    assert reason.startswith(f"harmonic {named} of i_a turns") if named else reason == ""


@pytest.mark.parametrize(
    ("course", "stands_out"),
    [(0.004 * _FLIPS, False), (0.02 * _FLIPS, True), (0.02 * (1.0 + 0.28 * _FLIPS), False)],
)
def test_a_harmonic_that_turns_within_noise_tells_nothing(course: Floats, stands_out: bool) -> None:
    """The mean of ten periods of 48 rows has a noise of 0.01 times 2 / sqrt(480): a line of 0.02 is more than
    five times that, and one of 0.004 is not, nor what it changes by beyond half of it."""
    reason = turned_around(_samples({3: course}, noise=0.01), _STEADY, "i_a")
    assert bool(reason) is stands_out


@pytest.mark.parametrize(("per_period", "tells"), [(4, False), (6, True), (9, True)])
def test_a_period_of_few_samples_has_few_harmonics_that_tell(per_period: int, tells: bool) -> None:
    """Below half of its samples."""
    few = _samples({2: 0.2 * _FLIPS}, per_period=per_period)
    assert bool(turned_around(few, _STEADY, "i_a")) is tells


@pytest.mark.parametrize(("periods", "tells"), [(3, False), (4, True)])
def test_parts_of_a_record_have_two_periods(periods: int, tells: bool) -> None:
    flips = np.where(np.arange(periods) < 2, 1.0, -1.0)
    assert bool(turned_around(_samples({3: 0.2 * flips}, periods=periods), _STEADY, "i_a")) is tells


@pytest.mark.parametrize(("with_lines", "cancels"), [(0.6, True), (0.73, False)])
def test_a_harmonic_and_lines_beside_it_may_cancel(with_lines: float, cancels: bool) -> None:
    """Without them it is 1.5 times as large as it is with them anywhere."""
    courses = with_lines * np.repeat([0.8, 1.0, 0.5, 0.7], 10)
    reason = turned_around(_samples({5: 0.2}), _STEADY, "i_a", _samples({5: 0.2 * courses}))
    assert ("harmonic 5" in reason) is cancels


def test_what_a_current_of_two_amplitudes_does_not_define_has_that_as_its_one_reason() -> None:
    time_s = np.arange(3000) / 10e3  # too few periods for a floor of what changes
    turned_rad = 2 * np.pi * 20.3 * time_s
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(time_s))
    i_a = np.where(time_s < 0.15, 5.0, 7.5) * np.cos(turned_rad) + noise
    track = track_angle(turned_rad % (2 * np.pi), 1)
    _, *others = current_spectrum(Block.from_arrays(10e3, {"i_a": "A"}, i_a=i_a), "i_a", track).measurements
    (reason,) = {each.reason for each in others}
    assert reason.startswith("the amplitude of i_a changes from 5.03 to 7.5 between parts of the window")


def test_a_dc_that_is_gone_within_a_period_makes_no_jump_of_the_fundamental() -> None:
    """By its leak the phase of the first period is another, by more than any later one."""
    jumps = 0
    for seed, decay_s in enumerate(np.geomspace(4e-3, 16e-3, 8)):
        random = np.random.default_rng(seed)
        t = np.arange(4000) / 1e4
        samples = 5.0 * np.cos(2.0 * np.pi * 50.3 * t + random.uniform(0.0, 2.0 * np.pi))
        samples += 2.0 * np.exp(-t / decay_s) + 0.01 * random.standard_normal(len(t))
        found = separate(samples, 1e4, track_angle(2.0 * np.pi * 50.3 * t, 1), "i_a", 0.0)
        assert found.moved.jump_rad == 0.0
        jumps += found.seen.jump_rad > 0.0
        numbers = current_spectrum(Block.from_arrays(1e4, {"i_a": "A"}, i_a=samples), "i_a", found.track)
        first = next(each for each in numbers.measurements if each.name == "current_fundamental")
        assert first.uncertainty is not None
        assert abs(first.value - 5.0) < 3.0 * first.uncertainty.standard
    assert jumps > 0
