"""Phases that move too little, or too fast, to be followed, angles that err without noise, and lines of which
a record has few cycles, or which are hardly beside the fundamental."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

_QUIET = Disturbance()
_PURE = replace(_QUIET, harmonics={5: 0.004, 7: 0.003}, periods=60.3, frequency_Hz=50.0)
STEADY: Mapping[str, Disturbance] = {
    "swing_of_milliradians": replace(_PURE, swing=(6e-5, 1.3)),
    "swing_of_milliradians_no_angle": replace(_PURE, swing=(6e-5, 1.3), angle=False),
    "walk_of_milliradians_no_angle": replace(_PURE, speed_walk=1e-5, angle=False),
    "angle_set_in_each_revolution": replace(_QUIET, angle_index_rad=2e-3, periods=100.4, frequency_Hz=50.0),
    "angle_wanders_slowly": replace(_PURE, angle_wander=(5e-4, 0.9)),
    "angle_wanders_noisily": replace(_PURE, angle_wander=(5e-4, 1.7), angle_noise_rad=1e-4),
    "line_of_three_cycles": replace(_QUIET, lines=((0.17, 0.04),), periods=20.3),
    "line_of_five_cycles_no_angle": replace(_QUIET, lines=((0.26, 0.04),), periods=20.6, angle=False),
    "line_a_bin_and_a_half_away": replace(_QUIET, lines=((1.0 + 1.46 / 40.4, 0.03),), periods=40.4),
    "line_below_by_a_bin_and_a_half": replace(_QUIET, lines=((1.0 - 1.44 / 40.4, 0.03),), periods=40.4),
    "dc_gone_within_a_period": replace(_QUIET, decay=(0.4, 0.01), periods=20.2),
    "line_in_five_periods": replace(_QUIET, lines=((1.66, 0.03),), periods=5.5),
}  # fmt: skip


FAMILIES = families_of(trial, STEADY)
