"""Families that were tried as a stranger would, after the uncertainties had been stated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.dynamic import Lag, Stepped, stepped_trial
from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

_QUIET = Disturbance()
STEADY: Mapping[str, Disturbance] = {
    "walk": replace(_QUIET, noise=1e-2, kind="walk"),
    "walk_few_periods": replace(_QUIET, noise=1e-2, kind="walk", periods=5.4),
    "resonant": replace(_QUIET, noise=1e-2, kind="resonant", periods=30.7),
    "resonant_no_angle": replace(_QUIET, noise=3e-3, kind="resonant", periods=60.2, angle=False),
    "popcorn": replace(_QUIET, noise=1e-2, kind="popcorn"),
    "bounded": replace(_QUIET, noise=2e-2, kind="bounded", periods=33.1),
    "clicks": replace(_QUIET, noise=1e-2, kind="clicks"),
    "fractional": replace(_QUIET, noise=1e-2, kind="fractional", periods=48.2),
    "fractional_few_periods": replace(_QUIET, noise=1e-2, kind="fractional", periods=6.3),
    "pink_and_white": replace(_QUIET, noise=2e-2, kind="pink_and_white", periods=70.4),
    "pink_few_periods": replace(_QUIET, noise=1e-2, kind="pink", periods=5.6),
    "pink_many_periods": replace(_QUIET, noise=1e-2, kind="pink", periods=300.1, frequency_Hz=140.0),
    "skewed": replace(_QUIET, noise=1e-2, kind="skewed", periods=25.6),
    "mixed_tails": replace(_QUIET, noise=1e-2, kind="mixed_tails", periods=90.3),
    "slow_memory": replace(_QUIET, noise=1e-2, colour=0.9996, periods=80.3),
    "coloured_few_periods": replace(_QUIET, noise=1e-2, colour=0.995, periods=3.7),
    "bits_10_drift_pink": replace(_QUIET, bits=10, drift=0.02, noise=3e-3, kind="pink", periods=60.7),
    "bits_11_walk": replace(_QUIET, bits=11, noise=3e-3, kind="walk", periods=44.4),
    "tones_close": replace(_QUIET, lines=((1.93, 0.01), (1.99, 0.008)), periods=50.3, noise=1e-3),
    "tones_close_no_angle": replace(_QUIET, lines=((6.21, 0.01), (6.24, 0.01)), periods=44.9, noise=2e-3,
        angle=False),
    "chirp_interference": replace(_QUIET, chirp=(0.01, 0.3, 9.2), periods=40.6, noise=1e-3),
    "chirp_no_angle": replace(_QUIET, chirp=(0.01, 2.2, 3.1), periods=70.2, noise=1e-3, angle=False),
    "hum_drifting": replace(_QUIET, chirp=(0.01, 2.49, 2.51), lines=((7.47, 0.004),), periods=50.8,
        noise=1e-3),
    "peaked_ripple": replace(_QUIET, peaked=0.3, periods=35.2, noise=3e-3),
    "peaked_ripple_swing": replace(_QUIET, peaked=0.2, swing=(0.005, 2.3), periods=62.8, noise=1e-2),
    "two_periods_pink": replace(_QUIET, periods=2.7, noise=1e-2, kind="pink"),
    "three_periods_heavy": replace(_QUIET, periods=3.3, noise=1e-2, kind="heavy"),
    "heavy_many_periods": replace(_QUIET, periods=250.4, frequency_Hz=97.3, noise=1e-2, kind="heavy"),
    "swing_heavy": replace(_QUIET, swing=(0.01, 1.9), periods=70.8, noise=1e-2, kind="heavy", counts=4096),
    "slip_pink": replace(_QUIET, slip=0.002, periods=55.2, noise=1e-2, kind="pink"),
    "line_beside_drift": replace(_QUIET, lines=((1.0 + 1.5 / 40.3, 0.03),), drift=5e-4, periods=40.3,
        noise=2e-3, angle=False),
    "line_beside_swing": replace(_QUIET, lines=((1.0 + 1.45 / 40.6, 0.03),), swing=(3e-4, 0.8), periods=40.6,
        noise=2e-3, angle=False),
    "current_across": replace(_QUIET, across=0.05, periods=35.4, noise=3e-4),
    "current_across_no_angle": replace(_QUIET, across=0.03, periods=61.7, noise=3e-4, angle=False),
}  # fmt: skip
STEPPED: Mapping[str, Stepped] = {
    "step_walk": Stepped(Lag(60.0, 0.4), 1e-2, kind="walk"),
    "step_resonant": Stepped(Lag(40.0, 0.6), 3e-3, kind="resonant"),
    "step_popcorn": Stepped(Lag(60.0, 0.5), 3e-3, kind="popcorn", held=True),
    "step_heavy": Stepped(Lag(80.0, 0.3), 1e-2, kind="heavy"),
    "step_fractional": Stepped(Lag(60.0, 0.4), 1e-2, kind="fractional"),
    "step_drifting_little": Stepped(Lag(240.0), 2e-4, drift=0.07, duration_s=0.1, held=True),
}


FAMILIES = (
    *families_of(trial, STEADY),
    *families_of(stepped_trial, STEPPED),
)
