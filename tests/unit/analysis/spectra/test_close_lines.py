"""Steady lines beside a harmonic: told, and taken out; what all harmonics do alike is none."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import FIRST_ROW, coherent_samples, spectrum_of
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.spectra.close_lines import close_lines
from benchtool.analysis.spectra.current import current_spectrum
from benchtool.analysis.spectra.interharmonics import Interharmonics
from benchtool.analysis.spectra.moving_tones import course_of
from benchtool.block import Block
from tests.at_length import at_length

Array = NDArray[np.float64]
RATE_HZ, PERIODS, PER_PERIOD, HIGHEST = 10e3, 40.4, 211.3, 50
LINES = {1: 1.0, 5: 0.03, 7: 0.02, 11: 0.01, 13: 0.005}
ROW = np.arange(round(PERIODS * PER_PERIOD), dtype=np.float64)


def current(
    random: np.random.Generator, noise: float, turned: Array | float = 0.0, load_angle: Array | float = 0.0
) -> Array:
    theta = 2.0 * np.pi * ROW / PER_PERIOD + turned
    phases = {k: k * theta + random.uniform(0, 2 * np.pi) for k in LINES}
    phases[1] = phases[1] + load_angle
    signal = sum(a * np.cos(phases[k]) for k, a in LINES.items())
    return np.asarray(signal) + noise * random.standard_normal(len(ROW))


def beside(order: int, bins: float, amplitude: float, phase: float) -> Array:
    turns = order * ROW / PER_PERIOD + bins * ROW / len(ROW)
    return np.asarray(amplitude * np.cos(2.0 * np.pi * turns + phase))


def found_in(signal: Array) -> Interharmonics | None:
    track = PhaseTrack(Polynomial([0.3, 2.0 * np.pi / PER_PERIOD]), len(signal), "as it was made")
    coherent = coherent_samples(signal, RATE_HZ, track)
    return close_lines(spectrum_of(coherent), len(coherent.values), HIGHEST).lines


def error_of(signal: Array, order: int) -> tuple[float, float]:
    """Return error and standard uncertainty of a harmonic of a record without an angle."""
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=signal)
    row = current_spectrum(block, "i_a", track_tone(signal)).tables[0].rows[order - 1]
    return row[2] - LINES[order], row[5]


def test_noise_alone_has_hardly_any_line() -> None:
    told = 0
    for seed in range(20):
        found = found_in(current(np.random.default_rng(seed), 1e-3))
        if found is not None:
            told += int(np.count_nonzero(np.abs(found.phasors) > 1e-4))
    assert told <= 1


@pytest.mark.parametrize(("order", "bins"), [(5, 0.3), (5, -0.7), (7, 0.15), (11, -0.4), (1, 0.6)])
def test_a_line_beside_a_harmonic_is_told_with_its_distance(order: int, bins: float) -> None:
    size = 0.3 * LINES[order] if order > 1 else 0.01
    random = np.random.default_rng(3)
    found = found_in(current(random, 1e-4) + beside(order, bins, size, 1.0))
    assert found is not None
    nearest = int(np.argmax(np.abs(found.phasors)))
    # the spectrum is over fewer periods than the record
    apart = (found.places[nearest] - 40 * order) * PERIODS / 40
    assert apart == pytest.approx(bins, abs=0.05)
    assert abs(found.phasors[nearest]) == pytest.approx(size, rel=0.1)


def test_a_line_that_hardly_turns_the_fundamental_is_told_by_its_amplitude_where_harmonics_do_not() -> None:
    """At some phases a line moves the phase to and fro alone, and harmonics in noise hardly tell whether the
    amplitude is one that all have in common."""
    for seed in range(8):
        signal = current(np.random.default_rng(seed), 5e-3) + beside(1, 0.65, 5e-3, 0.25 * np.pi * seed)
        found = found_in(signal)
        assert found is not None
        nearest = int(np.argmax(np.abs(found.phasors)))
        assert found.places[nearest] - 40.0 == pytest.approx(0.65, abs=0.1)
        assert abs(found.phasors[nearest]) == pytest.approx(5e-3, rel=0.15)


def test_an_amplitude_that_moves_is_no_line_where_harmonics_do_not_tell() -> None:
    share = ROW / len(ROW)
    for seed in range(6):
        random = np.random.default_rng(seed)
        swing = 1e-3 * np.cos(2.0 * np.pi * 1.6 * share + random.uniform(0.0, 2.0 * np.pi))
        for course in (2e-3 * (share - 0.5), 8e-3 * (share - 0.5) ** 2, 3e-3 * np.exp(-share / 0.3), swing):
            noise = 1e-3 * random.standard_normal(len(ROW))
            found = found_in(current(random, 0.0) * (1.0 + course) + noise)
            assert found is None or np.all(np.abs(found.phasors) < 2e-4)


def test_what_all_harmonics_do_alike_is_no_line() -> None:
    random, time = np.random.default_rng(5), ROW / len(ROW)
    turned = 2e-3 * np.sin(2.0 * np.pi * 0.4 * time)
    found = found_in((1.0 + 0.02 * time) * current(random, 1e-4, turned))
    assert found is None or np.all(np.abs(found.phasors) < 2e-5)


@pytest.mark.parametrize("order", [5, *at_length(1)])
def test_a_harmonic_beside_a_line_is_within_its_uncertainty(order: int) -> None:
    random, within, errors = np.random.default_rng(8), 0, []
    for _ in range(12):
        bins, phase = random.uniform(0.1, 0.9) * random.choice([-1, 1]), random.uniform(0, 6.28)
        size = random.uniform(0.1, 0.5) * LINES[order] * (0.03 if order == 1 else 1.0)
        error, u = error_of(current(random, 3e-4) + beside(order, bins, size, phase), order)
        within += abs(error) < 2.0 * u
        errors.append(abs(error) / size)
    assert within >= 10
    assert np.median(errors) < 0.05


def error_along_a_changing_speed(
    random: np.random.Generator, beside_5: list[tuple[float, float]]
) -> tuple[float, float]:
    """Return error and standard uncertainty of harmonic 5, of a speed that drifts by 3 %, with lines of
    constant frequency beside it, so many bins from its mean frequency and of so much of it."""
    time = ROW / len(ROW)
    turns = PERIODS * (time + 0.015 * (time**2 - time))
    signal = sum(a * np.cos(2 * np.pi * k * turns + random.uniform(0, 2 * np.pi)) for k, a in LINES.items())
    for bins, share in beside_5:
        phase = 2 * np.pi * (5 * PERIODS + bins) * time + random.uniform(0, 2 * np.pi)
        signal = signal + share * LINES[5] * np.cos(phase)
    signal = np.asarray(signal) + 1e-4 * random.standard_normal(len(ROW))
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=signal)
    track = track_angle(2 * np.pi * turns / 4, 4)
    row = current_spectrum(block, "i_a", track).tables[0].rows[4]
    return row[2] - LINES[5], row[5]


@pytest.mark.parametrize("bins", [-0.3, *at_length(0.1, 0.6)])
def test_a_line_of_constant_frequency_is_told_while_the_speed_changes(bins: float) -> None:
    random = np.random.default_rng(11)
    found = [error_along_a_changing_speed(random, [(bins, 0.2)]) for _ in range(6)]
    assert all(abs(error) < 3.0 * u for error, u in found)
    assert np.median([u for _, u in found]) < 0.01 * LINES[5]


@pytest.mark.parametrize("lines", [[(0.3, 0.2), (1.2, 0.2)], *at_length([(0.2, 0.15), (-0.6, 0.2)])])
def test_what_no_single_line_explains_is_uncertain(lines: list[tuple[float, float]]) -> None:
    """Two lines move amplitude and phase of a harmonic as none does by itself."""
    random = np.random.default_rng(12)
    for _ in range(12):
        signal = current(random, 1e-4)
        for bins, share in lines:
            signal = signal + beside(5, bins, share * LINES[5], random.uniform(0, 6.28))
        error, u = error_of(signal, 5)
        assert abs(error) < 2.5 * u


@pytest.mark.parametrize("cycles", [0.25, *at_length(2.0)])
def test_an_angle_between_fundamental_and_harmonics_that_moves_is_no_line(cycles: float) -> None:
    """As that of a load: it leaves the amplitude as it is, which a line beside the fundamental does not."""
    found = []
    for seed in range(8):
        random, time = np.random.default_rng(seed), ROW / len(ROW)
        load_angle = 0.01 * np.sin(2.0 * np.pi * cycles * time + random.uniform(0, 2 * np.pi))
        found.append(error_of(current(random, 1e-3, load_angle=load_angle), 1))
    assert all(abs(error) < 3.0 * u for error, u in found)
    assert np.median([u for _, u in found]) < 2e-4


def test_the_frequency_is_that_without_a_line_beside_the_fundamental() -> None:
    random = np.random.default_rng(2)
    signal = current(random, 1e-4) + beside(1, 0.4, 0.02, 0.5)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=signal)
    found = current_spectrum(block, "i_a", track_tone(signal)).measurements[0]
    assert found.uncertainty is not None
    error = found.value - RATE_HZ / PER_PERIOD
    assert abs(error) < 2.5 * found.uncertainty.standard
    assert abs(track_tone(signal).periods / (len(ROW) - 1) * RATE_HZ - RATE_HZ / PER_PERIOD) > 5.0 * abs(
        error
    )


@pytest.mark.parametrize(("harmonic", "is_known"), [(0.0, False), (0.03, True)])
def test_only_harmonics_tell_a_ramp_of_the_amplitude_from_a_line_beside_it(
    harmonic: float, is_known: bool
) -> None:
    """Within a third of a bin a line makes the amplitude rise evenly."""
    random, rows = np.random.default_rng(7), 41 * 200
    place = np.arange(rows) / rows
    theta = 2.0 * np.pi * 41.0 * place
    current = (1.0 + 0.01 * place) * (np.cos(theta) + harmonic * np.cos(5.0 * theta + 1.0))
    current += 3e-4 * random.standard_normal(rows)
    block = Block.from_arrays(10e3, {"i_a": "A"}, i_a=current)
    found = {each.name: each for each in current_spectrum(block, "i_a", track_tone(current)).measurements}
    assert (found["current_fundamental"].uncertainty is not None) is is_known
    assert (found["fundamental_frequency"].uncertainty is not None) is is_known


def test_what_a_converter_folds_to_beside_a_harmonic_is_no_line() -> None:
    """A period of 578.03 samples: orders 577 and 579 of the steps are 0.8 bins from the fundamental. With
    one line taken out in place of both the frequency would be off by half a millihertz."""
    rows, step = np.arange(13_988, dtype=np.float64), 2.04 / 256
    for seed in (1, 2, 16, 44, 86, 97):  # of the last four one line would take the place of both
        random = np.random.default_rng(seed)
        theta = 2.0 * np.pi * 17.3 * rows / RATE_HZ + random.uniform(0, 2 * np.pi)
        signal = sum(a * np.cos(k * theta + random.uniform(0, 2 * np.pi)) for k, a in LINES.items() if k < 8)
        signal = np.asarray(signal) + 3e-4 * random.standard_normal(len(rows))
        signal = np.round(signal / step + random.uniform()) * step
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=signal)
        found = current_spectrum(block, "i_a", track_tone(signal)).measurements[0]
        assert found.value == pytest.approx(17.3, abs=2.5e-4)


@pytest.mark.parametrize("bins", [1.35, 1.45, -1.45])
def test_a_line_beside_the_fundamental_is_told_at_any_phase_of_it(bins: float) -> None:
    """About 1.45 bins away, and elsewhere at two phases, it does not move the phase evenly."""
    random = np.random.default_rng(11)
    for phase in np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False):
        found = found_in(current(random, 1e-3) + beside(1, bins, 0.03, phase))
        assert found is not None
        nearest = int(np.argmax(np.abs(found.phasors)))
        assert (found.places[nearest] - 40) * PERIODS / 40 == pytest.approx(bins, abs=0.05)
        assert abs(found.phasors[nearest]) == pytest.approx(0.03, rel=0.1)


def test_a_load_that_moves_the_fundamental_alone_is_no_line() -> None:
    """Its amplitude or its phase, to and fro: on both sides alike."""
    random, time = np.random.default_rng(12), ROW / len(ROW)
    swing = np.sin(2.0 * np.pi * 1.45 * time + 0.7)
    for larger, load_angle in ((0.02 * swing, 0.0 * swing), (0.0 * swing, 0.02 * swing)):
        signal = current(random, 1e-4, load_angle=load_angle)
        signal += larger * np.cos(2.0 * np.pi * ROW / PER_PERIOD)
        found = found_in(signal)
        assert found is None or np.all(np.abs(found.phasors[np.abs(found.places - 40) < 2]) < 1e-3)


def test_a_line_that_leaks_to_all_harmonics_is_told_by_them_all_the_same() -> None:
    """And where windows cut it, the groups of harmonics are uncertain by its phase."""
    errors = []
    for seed in range(10):
        random = np.random.default_rng(seed)
        signal = current(random, 1e-3) + beside(1, -1.45, 0.03, random.uniform(0.0, 2.0 * np.pi))
        theta_m = 2.0 * np.pi * ROW / PER_PERIOD
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=signal)
        found = current_spectrum(block, "i_a", track_angle(theta_m, 1))
        row = found.tables[0].rows[4]
        subgroups = next(each for each in found.measurements if each.name == "current_thd_f_subgroups")
        assert subgroups.uncertainty is not None
        # of noise, three bins of each order from the second on
        truth = 100.0 * np.sqrt(
            sum(a**2 for k, a in LINES.items() if k > 1) + 49 * 3 * 2e-6 / (10 * PER_PERIOD)
        )
        errors.append(
            [(row[2] - LINES[5]) / row[5], (subgroups.value - truth) / subgroups.uncertainty.standard]
        )
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < 1.6)


def test_a_harmonic_whose_phase_is_not_followed_quite_is_no_line_in_its_own_place() -> None:
    turns = ROW / PER_PERIOD
    drift = 5e-4 * (ROW / ROW[-1] - 1.0) * turns  # of the track; the harmonics have not all of it
    signal = np.cos(2.0 * np.pi * (turns + drift))
    for order in (5, 7):
        signal += LINES[order] * np.cos(2.0 * np.pi * order * (turns + 0.3 * drift) + order)
    signal += 1e-4 * np.random.default_rng(3).standard_normal(len(ROW))
    of_drift = 5e-4 * 2.0 * np.pi / PER_PERIOD * np.array([0.0, -1.0, 1.0 / ROW[-1]])
    track = PhaseTrack(
        Polynomial([0.0, 2.0 * np.pi / PER_PERIOD]) + Polynomial(of_drift), len(ROW), "as made"
    )
    coherent = coherent_samples(signal, RATE_HZ, track)
    found = close_lines(
        spectrum_of(coherent),
        len(coherent.values),
        HIGHEST,
        course=course_of(track.turns_from(FIRST_ROW), FIRST_ROW, coherent),
    )
    sizes = [] if found.lines is None else [abs(each.phasor) for each in found.lines.moving]
    assert max(sizes, default=0.0) < 0.01 * LINES[7]
