"""The noise floor of a current whose amplitude or phase changes over few periods, or in more than one way."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis import CoherentSamples, CoherentSpectrum, noise_floor
from benchtool.analysis.coherent.spectrum import spectrum_of
from benchtool.analysis.noise.noise import NoiseFloor
from benchtool.analysis.noise.noise_of_periods import NoFloor, without_changes
from benchtool.analysis.noise.noise_over_time import NoiseOverTime
from benchtool.analysis.statistics.scatter import MeanError
from tests.unit.analysis.noise.lines_in_noise import spectrum_of_bins

_PER_PERIOD, _NOISE, _POLE = 48, 1e-3, 0.6
_WOBBLE_RAD = 2e-2
_OF_ONE = NoiseFloor(1.0, 10.0, 400, 0.03, 700.0)
Floats = NDArray[np.float64]


def _floors(wave: Floats, periods: int, step: float = 0.0) -> tuple[NoiseFloor, NoiseFloor | NoFloor]:
    """Return the plain floor of a wave of so many periods, read in steps, and that without changes."""
    samples = CoherentSamples(wave, periods, float(len(wave)), 10e3)
    spectrum = spectrum_of(samples)
    plain = noise_floor(spectrum)
    assert plain is not None
    return plain, without_changes(plain, spectrum, samples, has_stepped=False, step=step)


def _relative(
    periods: int, size: Floats, seed: int, *, turned_rad: Floats | float = 0.0
) -> tuple[float, float, float]:
    """Return the plain floor and that without changes over the noise, and the error of the latter over its
    uncertainty; `size` and `turned_rad` are the courses of amplitude and phase, shape (n,)."""
    at = 2 * np.pi * np.arange(periods * _PER_PERIOD) / _PER_PERIOD + turned_rad
    wave = size * (np.cos(at + 0.4) + 0.03 * np.cos(5 * at))
    wave += _NOISE * np.random.default_rng(seed).standard_normal(len(at))
    plain, found = _floors(wave, periods)
    assert isinstance(found, NoiseFloor)
    truth = 2.0 * _NOISE / np.sqrt(len(at))
    error = (found.amplitude - truth) / (found.relative_error * found.amplitude)
    return plain.amplitude / truth, found.amplitude / truth, error


@pytest.mark.parametrize(
    ("periods", "course"),
    [
        *((4, "ramp"), (9, "ramp"), (9, "step"), (9, "swing and ramp"), (40, "ramp"), (40, "swing and ramp")),
        (70, "step and a swing in few periods"),
    ],
)
def test_a_change_of_the_amplitude_is_no_noise(periods: int, course: str) -> None:
    place = np.linspace(-0.5, 0.5, periods * _PER_PERIOD)
    size = 1.0 + 0.08 * place
    if course == "step":
        size = np.where(place < 0.13, 1.0, 1.04)
    elif course == "swing and ramp":
        size = size + 0.005 * np.cos(2 * np.pi * 1.3 * place)
    elif course == "step and a swing in few periods":
        size = np.where(place < 0.13, 1.0, 0.92) + 0.006 * np.cos(2 * np.pi * 0.39 * periods * place)
    plain, found, error = np.transpose([_relative(periods, size, seed) for seed in range(30)])
    assert np.median(plain) > 1.5
    assert np.mean(found) == pytest.approx(1.0, abs=0.06)
    assert 0.6 < float(np.sqrt(np.mean(error**2))) < 1.4


@pytest.mark.parametrize("periods", [5, 9, 40])
def test_a_phase_that_slips_is_no_noise(periods: int) -> None:
    rows = periods * _PER_PERIOD
    slipped_rad = np.linspace(-0.03, 0.03, rows)
    plain, found, error = np.transpose(
        [_relative(periods, np.ones(rows), seed, turned_rad=slipped_rad) for seed in range(30)]
    )
    assert np.median(plain) > 1.5
    assert np.mean(found) == pytest.approx(1.0, abs=0.06)
    assert 0.6 < float(np.sqrt(np.mean(error**2))) < 1.4


@pytest.mark.parametrize("per_period", [3, 4, 5, 7])
def test_a_period_of_few_samples_has_no_orders_to_tell_changes_by(per_period: int) -> None:
    at = 2 * np.pi * np.arange(60 * per_period) / per_period
    wave = np.linspace(0.5, 1.5, len(at)) * np.cos(at)
    samples = CoherentSamples(wave, 60, float(len(at)), 10e3)
    spectrum = spectrum_of(samples)
    plain = noise_floor(spectrum)
    assert without_changes(plain, spectrum, samples, has_stepped=True) == plain


def test_the_floor_of_a_steady_amplitude_stays_as_it_is() -> None:
    pairs = [_relative(20, np.ones(20 * _PER_PERIOD), seed)[:2] for seed in range(40)]
    assert sum(plain == found for plain, found in pairs) >= 38


def test_noise_of_the_amplitude_is_noise() -> None:
    """Its sidebands are in phase, as those of a ramp are, and it differs from period to period."""
    at = 2 * np.pi * np.arange(80 * _PER_PERIOD) / _PER_PERIOD
    noise = [0.02 * np.random.default_rng(seed).standard_normal(len(at)) for seed in range(20)]
    floors = [_floors((1.0 + each) * np.cos(at), 80) for each in noise]
    assert sum(found == plain for plain, found in floors) >= 14


@pytest.mark.parametrize(("errors", "stays"), [(1.5, True), (3.0, False)])
def test_a_floor_that_errors_of_readings_may_be_all_of_stays(errors: float, stays: bool) -> None:
    """The root of the mean square of a bin that white errors of a step give is step / sqrt(3 n)."""
    place = (np.arange(20 * _PER_PERIOD) + 0.5) / (20 * _PER_PERIOD)
    wave = (1.0 + 0.1 * place) * np.cos(40 * np.pi * place)
    wave += _NOISE * np.random.default_rng(1).standard_normal(len(place))
    plain, found = _floors(wave, 20)
    assert isinstance(found, NoiseFloor)
    assert found.amplitude < 0.8 * plain.amplitude
    step = plain.amplitude / errors * np.sqrt(3.0 * len(place))
    assert (_floors(wave, 20, step)[1] == plain) is stays


def test_the_noise_below_the_first_order_is_as_that_of_the_lowest_orders() -> None:
    """Of noise that most of is there, orders from 1 on alone would tell too little."""
    floors = []
    for seed in range(40):
        place = (np.arange(60 * _PER_PERIOD) + 0.5) / (60 * _PER_PERIOD)
        wave = (1.0 + 0.5 * place) * np.cos(120 * np.pi * place) + _coloured(len(place), _POLE, seed)
        found = _floors(wave, 60)[1]
        if isinstance(found, NoiseFloor):  # in few records it looks like bursts
            floors.append((found.amplitude, 2.0 * found.of_bins, np.sqrt(2.0 / found.dof)))
    assert len(floors) >= 30
    amplitude, relative, of_dof = np.transpose(floors)
    bins = np.arange(1, len(spectrum_of(CoherentSamples(wave, 60, float(len(place)), 10e3)).amplitude))
    bins = bins[(bins % 60 > 1) & (bins % 60 < 59)]
    power = 4.0 * _NOISE**2 / np.abs(1.0 - _POLE * np.exp(-2j * np.pi * bins / len(place))) ** 2 / len(place)
    assert np.mean(amplitude**2) == pytest.approx(np.mean(power), rel=0.05)
    assert relative == pytest.approx(of_dof, rel=0.05)  # as of a power that has so many


def test_noise_that_lies_below_the_first_order_shows_beside_the_fundamental() -> None:
    """Differences of periods have none of it, and the wobble of the phase keeps the spectrum from telling."""
    pole, rows, error, plain = 0.98, 60 * _PER_PERIOD, [], []
    bins = np.arange(1, rows // 2)
    bins = bins[(bins % 60 > 1) & (bins % 60 < 59)]
    density = 4.0 * _NOISE**2 / np.abs(1.0 - pole * np.exp(-2j * np.pi * bins / rows)) ** 2 / rows
    truth = np.sqrt(np.mean(density))
    for seed in range(40):
        turns = np.arange(rows) / _PER_PERIOD
        wave = np.cos(2 * np.pi * turns + _WOBBLE_RAD * np.cos(0.5 * np.pi * turns + seed))
        floor, found = _floors(wave + _coloured(rows, pole, seed), 60)
        if isinstance(found, NoiseFloor) and found.highest != floor.highest:
            error.append((found.amplitude / truth - 1.0) / found.of_bins)
            plain.append(found.amplitude / truth)
    assert len(error) >= 20
    assert np.mean(plain) == pytest.approx(1.0, abs=0.15)
    assert 0.6 < float(np.sqrt(np.mean(np.square(error)))) < 1.4


def test_noise_whose_level_changes_tells_less_than_noise_of_one_level() -> None:
    error = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        place = (np.arange(40 * _PER_PERIOD) + 0.5) / (40 * _PER_PERIOD)
        level = np.exp(0.2 * random.standard_normal(40))
        noise = _NOISE * np.repeat(level, _PER_PERIOD) * random.standard_normal(len(place))
        found = _floors((1.0 + 0.3 * place) * np.cos(80 * np.pi * place) + noise, 40)[1]
        if isinstance(found, NoiseFloor):
            truth = 2.0 * np.sqrt(np.mean(noise**2) / len(place))
            error.append((found.amplitude - truth) / (found.of_bins * found.amplitude))
    assert len(error) >= 15
    assert float(np.sqrt(np.mean(np.square(error)))) < 1.4


def _floors_of_steps(periods: int, seeds: int, at: float) -> list[NoiseFloor | NoFloor]:
    found = []
    for seed in range(seeds):
        place = (np.arange(periods * _PER_PERIOD) + 0.5) / (periods * _PER_PERIOD)
        size = np.where(place < at, 1.0, 1.05)
        wave = size * np.cos(2 * np.pi * periods * place + 0.4)
        wave += _NOISE * np.random.default_rng(seed).standard_normal(len(place))
        found.append(_floors(wave, periods)[1])
    return found


def test_a_step_in_all_differences_of_few_periods_leaves_no_floor() -> None:
    """Of three second differences of five periods all have a part of a step in the third."""
    assert _floors_of_steps(5, 12, 0.49).count(NoFloor.FEW_PERIODS) >= 11


def test_the_power_of_many_periods_is_not_that_of_all_but_the_largest() -> None:
    """Against the least of a hundred differences one in ten or twenty is more than chance allows."""
    floors = _floors_of_steps(120, 12, 0.531)
    truth = 2.0 * _NOISE / np.sqrt(120 * _PER_PERIOD)
    error = [each.amplitude / truth - 1.0 for each in floors if isinstance(each, NoiseFloor)]
    assert len(error) == 12
    assert abs(float(np.mean(error))) < 0.005


def _coloured(rows: int, pole: float, seed: int) -> Floats:
    noise = np.random.default_rng(seed).standard_normal(rows + 2_000)
    return np.asarray(signal.lfilter([_NOISE], [1.0, -pole], noise)[2_000:])


def _floor_of_coloured(
    pole: float, seed: int, *, follows: bool, per_period: int = 100
) -> tuple[float, float]:
    """Return the floor of 64 periods over the noise, and its error over its uncertainty; of a phase that
    follows all that moves the fundamental more slowly than a sixth of its frequency."""
    rows = 64 * per_period
    at = 2 * np.pi * np.arange(rows) / per_period
    noise = _coloured(rows, pole, seed)
    if follows:
        bins = np.fft.fft(noise * np.exp(-1j * at))
        slow = np.abs(np.fft.fftfreq(rows)) * rows < 10.5
        course = np.fft.ifft(np.where(slow, bins, 0.0))
        noise -= 2.0 * np.real(1j * np.imag(course) * np.exp(1j * at))  # of which the course in quadrature is
    samples = CoherentSamples(np.cos(at) + noise, 64, float(rows), 10e3)
    spectrum = spectrum_of(samples)
    plain = noise_floor(spectrum, has_moved=follows, follows_signal=follows)
    found = without_changes(plain, spectrum, samples, has_stepped=False, follows_signal=follows)
    assert isinstance(found, NoiseFloor)
    place = np.arange(len(spectrum.amplitude))
    between = place[(place % 64 > 1) & (place % 64 < 63)]
    density = 4.0 * _NOISE**2 / np.abs(1.0 - pole * np.exp(-2j * np.pi * between / rows)) ** 2 / rows
    truth = float(np.sqrt(np.mean(density)))
    return found.amplitude / truth, (found.amplitude - truth) / (found.relative_error * found.amplitude)


@pytest.mark.parametrize("follows", [False, True])
def test_the_noise_that_a_phase_took_along_counts(follows: bool) -> None:
    """Without it the floor were 4 % low, and with all that the phase may have left, u half of it."""
    floor, error = np.transpose([_floor_of_coloured(0.95, seed, follows=follows) for seed in range(40)])
    assert np.mean(floor) == pytest.approx(1.0, abs=0.013)
    assert 0.6 < float(np.sqrt(np.mean(error**2))) < 1.4


def test_a_step_is_seen_in_few_periods_of_noise() -> None:
    """Of the powers of its differences the low orders have most, as few orders alike would."""
    errors = []
    for each in _floors_of_steps(8, 30, 0.531):
        assert isinstance(each, NoiseFloor)
        truth = 2.0 * _NOISE / np.sqrt(8 * _PER_PERIOD)
        assert each.amplitude == pytest.approx(truth, rel=0.2)
        errors.append((each.amplitude - truth) / (each.relative_error * each.amplitude))
    assert float(np.sqrt(np.mean(np.square(errors)))) < 1.4


@pytest.mark.parametrize("phase_rad", [0.0, 0.7, 2.2])
def test_one_difference_of_three_periods_tells_no_step_from_noise(phase_rad: float) -> None:
    """A step near the end of a period has orders of about one size in it."""
    place = (np.arange(3 * _PER_PERIOD) + 0.5) / (3 * _PER_PERIOD)
    wave = np.where(place < 0.66, 1.0, 1.056) * np.cos(6 * np.pi * place + phase_rad)
    wave += _NOISE * np.random.default_rng(3).standard_normal(len(place))
    assert _floors(wave, 3)[1] is NoFloor.FEW_PERIODS


def _beside(in_phase: Floats | float, quadrature: Floats | float, periods: int) -> CoherentSpectrum:
    """Return a spectrum whose floor is 1, as much of it in phase with a fundamental as in quadrature: within
    an order of that so much of each, from the nearest bin on."""
    bins = np.arange(periods * 21 + 1)
    parts = []
    for power in (in_phase, quadrature):
        of_bins = np.full(len(bins), math.log(2.0))  # the median of noise of this mean square
        of_bins[periods + 1 : 2 * periods] = power
        of_bins[1:periods] = of_bins[2 * periods - 1 : periods : -1]
        parts.append(np.sqrt(0.5 * of_bins))
    phasor = np.where(bins == periods, 1e3, parts[0] + 1j * parts[1])
    return spectrum_of_bins(phasor, periods)


def _white(periods: int, per_period: int = 48, seed: int = 0) -> Floats:
    """Return samples of which a bin of the spectrum has a mean square of one."""
    noise = np.random.default_rng(seed).standard_normal(periods * per_period)
    return np.asarray(noise * np.sqrt(0.25 * len(noise)))


def _apart(
    spectrum: CoherentSpectrum, samples: Floats, given: NoiseFloor | None = _OF_ONE, **how: bool
) -> NoiseFloor | NoFloor:
    """Return the floor without changes by a spectrum and by samples that need not be those of it."""
    of_samples = CoherentSamples(samples, spectrum.periods, float(len(samples)), 10e3)
    return without_changes(given, spectrum, of_samples, **{"has_stepped": False} | how)


@pytest.mark.parametrize(("evenness", "quantile"), [(1.0, 15.977), (0.5, 99.0)])
def test_sidebands_change_where_a_ratio_of_variances_is_no_chance(evenness: float, quantile: float) -> None:
    """The two pairs of three periods have four degrees of freedom, or two where the noise is uneven: of
    F(4, 4) and F(2, 2) one in a hundred is above these (NIST/SEMATECH e-Handbook, 1.3.6.7.3)."""
    floor = replace(_OF_ONE, over_time=NoiseOverTime(MeanError(0.0, math.inf), evenness))
    for ratio, changes in ((0.97 * quantile, False), (1.03 * quantile, True)):
        for each in (_beside(1.0, ratio, 3), _beside(ratio, 1.0, 3)):
            assert _apart(each, _white(3), floor) == (NoFloor.FEW_PERIODS if changes else floor)


def test_what_a_phase_took_along_is_no_change() -> None:
    taken = _beside(1.0, np.repeat([0.02, 1.0], [24, 15]), 40)
    quiet = 0.5 * _white(40)
    assert _apart(taken, quiet, follows_signal=True) == _OF_ONE
    found = _apart(taken, quiet)
    assert isinstance(found, NoiseFloor)
    assert found.highest == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("has_stepped", [False, True])
def test_a_floor_is_that_of_differences_where_these_have_less(has_stepped: bool) -> None:
    moved = _beside(1.0, 20.0, 40)
    for size, is_less in ((0.8, True), (1.1, False)):
        found = _apart(moved, size * _white(40), has_stepped=has_stepped)
        assert isinstance(found, NoiseFloor)
        if not is_less:
            assert found == _OF_ONE
            continue
        assert found.highest == pytest.approx(size, rel=0.05)
        assert found.amplitude == found.highest
        # second differences overlap: as many powers as (n - 2) / (35 / 18), of 21 orders
        assert found.dof == pytest.approx(2.0 * 21 * 38 * 18 / 35, rel=0.2)


def test_the_noise_below_the_first_order_is_in_the_two_orders_around_the_fundamental() -> None:
    """As much in phase as in quadrature, it is twice what is in phase: two of 21.6 orders have 1 in place of
    0.01. Less than a fifth of that in quadrature may be the image of a ramp, and a line counts once."""
    samples = 0.1 * _white(40)
    for moved, is_image in ((4.0, False), (7.0, True)):
        quadrature = np.full(39, moved)
        quadrature[[7, 21]] = 1e3
        in_phase = np.repeat([100.0, 1.0], [1, 38])
        for sizes in ((in_phase, quadrature), (quadrature, in_phase)):
            found = _apart(_beside(*sizes, 40), samples)
            plain = _apart(_beside(*sizes, 40), samples, has_stepped=True)
            assert isinstance(found, NoiseFloor)
            assert isinstance(plain, NoiseFloor)
            assert plain.highest == pytest.approx(0.1, rel=0.05)
            more = 0.0 if is_image else 2.0 * (1.0 - 0.01) / 21.6
            assert found.highest**2 == pytest.approx(plain.highest**2 + more, rel=1e-3)
            # by the 37 pairs from the second on
            of_both = 0.0 if is_image else (2.0 / 21.6 / found.highest**2) ** 2 / 37.0
            assert 2.0 / found.dof == pytest.approx(of_both or 2.0 / plain.dof, rel=0.01)


def test_the_odds_of_noise_go_by_the_distance_from_two_levels() -> None:
    """Of normal distributions about 1 and 0.6, as wide as a quarter of their distance, the logarithm of the
    odds is linear: 0.4 of a distance d from their middle over the variance."""
    floor = replace(_OF_ONE, least=0.6)
    of_few = _apart(_beside(1.0, 1.0, 31), 0.7 * _white(31), floor, follows_signal=True)
    assert of_few == floor
    log_odds = []
    for size in (0.7, 0.8, 0.9):
        found = _apart(_beside(1.0, 1.0, 32), size * _white(32), floor, follows_signal=True)
        assert isinstance(found, NoiseFloor)
        assert replace(found, all_noise=0.5) == floor
        log_odds.append(math.log(found.all_noise / (1.0 - found.all_noise)))
    assert log_odds[1] == pytest.approx(0.0, abs=1.0)
    assert np.diff(log_odds) == pytest.approx(0.4 * 0.1 / (0.1**2 + 0.026**2), rel=0.1)


@pytest.mark.parametrize(("loud", "is_told"), [(2, True), (3, False)])
def test_noise_in_bursts_is_no_step(loud: int, is_told: bool) -> None:
    """Of 38 differences four may have more; a burst in so many periods is in two more of them."""
    samples = 0.5 * _white(40).reshape(40, -1)
    samples[20 : 20 + loud] *= 50.0
    found = _apart(_beside(1.0, 20.0, 40), samples.ravel(), has_stepped=True)
    assert isinstance(found, NoiseFloor) if is_told else found is NoFloor.BURSTS


@pytest.mark.parametrize(("periods", "is_told"), [(6, False), (7, True)])
def test_a_step_in_the_middle_leaves_two_of_five_differences(periods: int, is_told: bool) -> None:
    truth = 2.0 * _NOISE / math.sqrt(periods * _PER_PERIOD)
    for found in _floors_of_steps(periods, 6, 0.49):
        if not is_told:
            assert found is NoFloor.FEW_PERIODS
            continue
        assert isinstance(found, NoiseFloor)
        assert found.amplitude == pytest.approx(truth, rel=0.25)


def test_eight_samples_of_a_period_have_orders_to_tell_changes_by() -> None:
    found = _apart(_beside(1.0, 20.0, 40), 0.5 * _white(40, 8), has_stepped=True)
    assert isinstance(found, NoiseFloor)
    assert found.highest == pytest.approx(0.5, rel=0.1)


def _in_order(order: int, phasors: Floats) -> Floats:
    """Return samples that have one order alone, of these phasors in successive periods."""
    turned = 2.0 * np.pi * order * np.arange(_PER_PERIOD) / _PER_PERIOD
    return np.asarray(np.outer(phasors, np.cos(turned)).ravel())


def test_below_the_first_order_is_as_much_as_in_the_mean_of_the_first_three() -> None:
    """Of 21.6 orders, as the orders from 1 to 21 stand for 20.6."""
    phasors, moved = np.tile([1.0, -1.0], 20), _beside(1.0, 20.0, 40)
    power = {}
    for order in (2, 3, 4, 21):
        found = _apart(moved, _in_order(order, phasors), has_stepped=True)
        assert isinstance(found, NoiseFloor)
        power[order] = found.highest**2
    assert power[21] == pytest.approx(power[4])
    for order in (2, 3):
        assert power[order] / power[4] == pytest.approx(1.0 + (1.0 / 3.0) / (20.6 / 21.0))


def test_noise_of_the_amplitude_alone_is_none_of_the_floor() -> None:
    """What the fundamental has more than the orders beside it."""
    moved, samples = _beside(1.0, 20.0, 40), 0.5 * _white(40)
    swings = _in_order(1, np.random.default_rng(5).standard_normal(40))
    still, found = (_apart(moved, each, has_stepped=True) for each in (samples, samples + swings))
    assert isinstance(still, NoiseFloor)
    assert isinstance(found, NoiseFloor)
    assert found.highest == pytest.approx(still.highest, rel=0.02)


def test_five_differences_of_one_order_are_enough() -> None:
    """They overlap, as 5 / (35 / 18) of them, and are of one size."""
    found = _apart(_beside(1.0, 20.0, 7), _in_order(5, np.tile([1.0, -1.0], 4)[:7]), has_stepped=True)
    assert isinstance(found, NoiseFloor)
    assert found.dof == pytest.approx(2.0 * (5.0 * 18.0 / 35.0 + 1.0))


def test_bursts_are_noise_of_a_phase_that_was_followed() -> None:
    floor, samples = replace(_OF_ONE, least=0.6), 0.6 * _white(40).reshape(40, -1)
    odds = []
    for loud in (1, 4):  # a burst in one period may be a step
        bursts = samples.copy()
        bursts[10 : 10 + loud] *= 4.0
        found = _apart(_beside(1.0, 1.0, 40), bursts.ravel(), floor, follows_signal=True)
        assert isinstance(found, NoiseFloor)
        odds.append(found.all_noise)
    assert odds[0] < 0.05 < 0.95 < odds[1]


@pytest.mark.parametrize("has_stepped", [False, True])
def test_a_current_that_stops_has_no_floor(has_stepped: bool) -> None:
    samples = _white(40) * (np.arange(40 * _PER_PERIOD) < 12 * _PER_PERIOD)
    assert _apart(_beside(1.0, 20.0, 40), samples, has_stepped=has_stepped) is NoFloor.SILENT
    assert _apart(_beside(1.0, 1.0, 40), samples) == _OF_ONE
    assert _apart(_beside(1.0, 1.0, 40), samples, None) is NoFloor.FEW_BINS
    follows = replace(_OF_ONE, least=0.6)
    assert _apart(_beside(1.0, 1.0, 40), samples, follows, follows_signal=True) == follows
    silent = spectrum_of_bins(np.zeros(40 * 21, dtype=np.complex128), 40)
    assert _apart(silent, _white(40), follows, follows_signal=True) == follows


def test_noise_in_bursts_that_all_differences_have_is_the_floor() -> None:
    """Sidebands are more in quadrature as the bursts are; what differs between periods is as much."""
    white = _white(40).reshape(40, -1)
    bursts = white.copy()
    bursts[[5, 14, 22, 31]] *= 3.0
    bursts *= float(np.std(white) / np.std(bursts))
    assert _apart(_beside(1.0, 20.0, 40), 0.5 * bursts.ravel()) is NoFloor.BURSTS
    assert _apart(_beside(1.0, 20.0, 40), 1.2 * bursts.ravel()) == _OF_ONE
