"""Spectra, waterfall and the flux plane, on signals whose answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Block, Channel, Gap
from benchtool.live.panels import locus
from benchtool.live.panels.spectrum import RunningSpectrum, bars, decibels, spectrogram

RATE_HZ = 1000.0


def signal(
    frequency_Hz: float, rows: int = 4000, fifth: float = 0.02
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    t = np.arange(rows) / RATE_HZ
    return np.asarray(
        0.5 + 0.8 * np.sin(2 * np.pi * frequency_Hz * t) + 0.8 * fifth * np.sin(10 * np.pi * frequency_Hz * t)
    )


@given(st.floats(11.0, 60.0))
def test_the_fundamental_and_its_harmonics_are_found(frequency_Hz: float) -> None:
    found = bars(signal(frequency_Hz), RATE_HZ, "i_a", "A")
    assert found is not None
    assert found.fundamental_Hz == pytest.approx(frequency_Hz, abs=0.02)
    assert found.fundamental == pytest.approx(0.8, rel=0.16)  # between two bins of a Hann window
    assert found.harmonic_percent[3] == pytest.approx(2.0, rel=0.2)
    assert np.argmax(found.harmonic_percent) == 3
    assert len(found.frequency_Hz) <= 400
    highest = found.frequency_Hz[np.argmax(found.amplitude_dB)]
    assert highest == pytest.approx(frequency_Hz, abs=1.5)


def test_decibels_are_of_a_thousandth() -> None:
    assert decibels(np.array([1e-3, 1.0, 0.0, 1e-6])).tolist() == pytest.approx([0.0, 60.0, 0.0, 0.0])


@pytest.mark.parametrize("samples", [np.zeros(1000), np.full(1000, 2.0), np.full(1000, np.nan), np.zeros(3)])
def test_what_has_no_spectrum_shows_none(samples: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    assert bars(samples, RATE_HZ, "i_a", "A") is None


def test_noise_has_no_harmonics() -> None:
    random = np.random.default_rng(3)
    found = bars(0.01 * random.standard_normal(16_384), RATE_HZ, "i_a", "A")
    assert found is not None
    assert not found.harmonic_percent.any()
    with_a_sine = bars(signal(40.0, 16_384) + 0.01 * random.standard_normal(16_384), RATE_HZ, "i_a", "A")
    assert with_a_sine is not None
    assert with_a_sine.harmonic_percent[3] == pytest.approx(2.0, rel=0.3)


def test_a_waterfall_follows_a_frequency_in_time() -> None:
    samples = np.concatenate((signal(50.0), signal(400.0)))
    picture, row_s = spectrogram(samples, RATE_HZ)
    assert picture.shape[1] == 192
    assert 100 <= picture.shape[0] <= 160
    assert row_s * picture.shape[0] == pytest.approx(6.0, rel=0.05)
    peaks = picture[:, 4:].argmax(axis=1) + 4
    assert peaks[0] * 500.0 / 192 == pytest.approx(50.0, abs=4.0)
    assert peaks[-1] * 500.0 / 192 == pytest.approx(400.0, abs=4.0)


def test_a_running_spectrum_is_bounded_and_restarts_after_a_gap() -> None:
    running = RunningSpectrum("i_a", "A", RATE_HZ)
    channel = (Channel("i_a", "A"),)
    whole = signal(40.0, 200_000)[:, None]
    for begin in range(0, len(whole), 500):
        running.add(Block(channel, begin, 1, 1e-3, whole[begin : begin + 500]), broken=False)
        running.bars()
    assert len(running.waterfall()) == 150
    assert len(running._samples) == 4000
    found = running.bars()
    assert found is not None
    assert found.fundamental_Hz == pytest.approx(40.0, abs=0.05)
    running.add(Block(channel, 0, 1, 1e-3, whole[:40], (Gap(20, 5),)), broken=False)
    assert running.bars() is None
    assert len(running._samples) == 20


def test_the_planes_scale_is_the_hexagons() -> None:
    corners = locus.hexagon(1.25 * 0.17)
    assert np.hypot(*corners.T) == pytest.approx(1.25 * 0.17)
    vertex_V = 2.0 / 3.0 * 122.5
    assert corners[0][0] * 1e3 * locus.hexagon_V_per_mWb(0.17, 122.5) == pytest.approx(vertex_V)
    # the second vertex is 60 degrees anticlockwise as seen: the viewer's vertical axis points down
    assert math.degrees(math.atan2(-corners[1][1], corners[1][0])) == pytest.approx(60.0)
    assert np.hypot(*locus.circle(0.17).T) == pytest.approx(0.17)
