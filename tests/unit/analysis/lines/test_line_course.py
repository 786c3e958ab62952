"""The mean frequency of a line whose phase swings slowly, hidden in its main lobe."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis.lines.line_course import along_course
from benchtool.analysis.lines.line_models import Complexes, Floats
from benchtool.analysis.lines.lines import sinusoids_of
from benchtool.analysis.lines.steadiness import Line
from benchtool.analysis.spectral_window import spectral_window
from tests.at_length import at_length

_COUNT, _PLACE = 1500, 80.3


def _errors(swing_rad: float, cycles: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Errors over their uncertainties of the place of a line in 40 records."""
    found = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        time = np.arange(_COUNT) / _COUNT
        phase = 2 * np.pi * _PLACE * time + random.uniform(0, 2 * np.pi)
        phase += swing_rad * np.sin(2 * np.pi * cycles * time + random.uniform(0, 2 * np.pi))
        line = sinusoids_of(2.0 + np.cos(phase) + 0.3 * random.standard_normal(_COUNT))[0]
        mean = (phase[-1] - phase[0]) / (2 * np.pi) * _COUNT / (_COUNT - 1)
        if not line.reason:
            found.append((line.place - mean) / line.of_place)
    return np.array(found)


@pytest.mark.parametrize(
    ("rows", "noise"), [(1000, 4e-4), (3000, 4e-2), *at_length((1000, 4e-2), (3000, 4e-4))]
)
def test_the_mean_of_a_drift_is_over_all_rows_however_quiet_they_are(rows: int, noise: float) -> None:
    """Parts of the record are not of one length, of few cycles, and the frequency changes within them."""
    errors = []
    for seed in range(16):
        random = np.random.default_rng(seed)
        time, place = np.arange(rows) / rows, 0.06 * rows + random.uniform()
        # as far from the middle of the rows, half a row behind the begin of time
        since = time - 0.5 + 0.5 / rows
        turns = place * (time + 0.0075 * (since**2 - 0.25))
        samples = 2.0 + np.cos(2 * np.pi * turns + random.uniform(0, 2 * np.pi))
        found = sinusoids_of(samples + noise * random.standard_normal(rows))[0]
        if found.is_one:
            errors.append((found.place - place) / found.of_place)
    assert len(errors) >= 12
    assert 0.4 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


@pytest.mark.parametrize(("swing_rad", "cycles"), [(0.0, 1.0), (0.4, 0.7), *at_length((0.3, 0.9))])
def test_the_mean_is_within_its_uncertainty_under_a_slow_swing(swing_rad: float, cycles: float) -> None:
    errors = _errors(swing_rad, cycles)

    assert len(errors) >= 30
    assert 0.6 < float(np.sqrt(np.mean(errors**2))) < 1.5


def _read(
    *others: tuple[float, float], seed: int = 3, count: int = _COUNT, swing_rad: float = 0.0
) -> tuple[Floats, Complexes]:
    """Return samples of a line at `_PLACE`, of others at place and amplitude, and their bins under a Hann
    window."""
    random, time = np.random.default_rng(seed), np.arange(count) / count
    samples = np.cos(2 * np.pi * _PLACE * time + swing_rad * np.sin(2 * np.pi * 0.7 * time))
    for place, amplitude in others:
        samples += amplitude * np.cos(2 * np.pi * place * time + random.uniform(0, 2 * np.pi))
    samples += 0.02 * random.standard_normal(count)
    return samples, _bins(samples)


def _bins(samples: Floats) -> Complexes:
    weights = spectral_window("hann", len(samples))
    return np.asarray(
        np.fft.rfft((samples - np.mean(samples)) * weights) * (2.0 / float(np.sum(weights))), np.complex128
    )


def _line(place: float, amplitude: float = 1.0) -> Line:
    return Line(place, amplitude, 1e-3, 1e-3, 1e-3, 1e-3, is_one=True)


LINE = _line(_PLACE)


@pytest.mark.parametrize(
    "others",
    [
        ((_PLACE - 5.0, 0.1), (_PLACE + 5.0, 0.15)),
        ((_PLACE + 9.2, 0.2), (_PLACE - 5.0, 0.15), (_PLACE + 5.5, 0.1)),
    ],
)
def test_a_line_with_sidebands_stays_between_them(others: tuple[tuple[float, float], ...]) -> None:
    samples, bins = _read(*others)
    assert along_course(samples, bins, LINE, [_line(*each) for each in others]) is LINE


@pytest.mark.parametrize(
    "others",
    [((_PLACE - 5.0, 0.1), (_PLACE + 7.0, 0.1)), ((_PLACE - 5.0, 0.1), (_PLACE + 5.0, 0.3)), ((85.0, 0.4),)],
)
def test_lines_that_are_no_sidebands_are_taken_out(others: tuple[tuple[float, float], ...]) -> None:
    samples, bins = _read(*others, swing_rad=0.2)
    found = along_course(samples, bins, LINE, [_line(*each) for each in others])
    mean = _PLACE + 0.2 * np.sin(2 * np.pi * 0.7) / (2 * np.pi)
    assert found is not LINE
    assert abs(found.place - mean) < 2.5 * found.of_place < 0.02


@pytest.mark.parametrize("cycles", [0.4, 1.3, 2.4])
def test_what_is_slower_than_the_lines_turns_none_of_them(cycles: float) -> None:
    """Parts hold a period of the line, in which it is a slope."""
    errors = []
    for seed in range(20):
        random, time = np.random.default_rng(seed), np.arange(700) / 700
        samples = np.cos(2 * np.pi * 30.3 * time + random.uniform(0, 2 * np.pi))
        samples += 0.8 * np.cos(2 * np.pi * cycles * time + random.uniform(0, 2 * np.pi))
        samples += 5e-3 * random.standard_normal(700)
        found = along_course(samples, _bins(samples), _line(30.3), ())
        errors.append((found.place - 30.3) / found.of_place)
    assert 0.4 < float(np.sqrt(np.mean(np.square(errors)))) < 1.5  # 3 to 11 with a mean of each part alone


@pytest.mark.parametrize(
    "line",
    [
        replace(LINE, is_one=False),
        replace(LINE, of_mean="it decays"),
        replace(LINE, of_place=1e-6),  # no noise hides a swing
        replace(LINE, of_place=0.1),  # a turn may be lost
        _line(8.4),  # too few periods for its parts
    ],
)
def test_a_line_whose_course_tells_nothing_more_stays_as_it_is(line: Line) -> None:
    samples, bins = _read()
    assert along_course(samples, bins, line, ()) is line


def test_a_line_of_few_rows_in_its_parts_stays_as_it_is() -> None:
    samples, bins = _read(count=66)
    assert along_course(samples, bins, LINE, ()) is LINE
