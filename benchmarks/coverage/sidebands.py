"""Families whose fundamental alone has sidebands, as of a slip, whose speed wanders over many periods, or
both, or whose amplitude swings as well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

_QUIET = Disturbance()
_MANY = replace(_QUIET, periods=118.3, angle=False)
_SLOTS = {5: 0.04, 7: 0.02, 17: 0.01}
RECORDS: Mapping[str, Disturbance] = {
    "slip_sidebands": replace(_QUIET, lines=((0.93, 0.012), (1.07, 0.028)), periods=60.4),
    "slip_sidebands_no_angle": replace(
        _QUIET, lines=((0.94, 0.03), (1.06, 0.015)), angle=False, periods=75.7
    ),
    "decaying_dc_and_line": replace(_QUIET, decay=(0.2, 0.1), lines=((2.46, 0.02),), periods=10.2),
    "one_sideband": replace(_QUIET, lines=((0.57, 0.02),), periods=50.0),
    "drift_many_periods_no_angle": replace(_MANY, drift=0.006),
    "swing_many_periods_no_angle": replace(_MANY, swing=(0.004, 0.9)),
    "speed_memory_many_periods_no_angle": replace(_MANY, speed_memory=(0.003, 0.05), periods=113.6),
    "swing_of_both_amplitude_no_angle": replace(_MANY, amplitude_swing=(0.06, 1.3), swing=(0.0008, 1.3)),
    "swings_of_two_rates_no_angle": replace(_MANY, amplitude_swing=(0.03, 2.1), swing=(0.0012, 0.9)),
    "line_beside_and_swing_no_angle": replace(_MANY, lines=((1.11, 0.015),), swing=(0.003, 1.4)),
    "line_beside_and_drift_no_angle": replace(_MANY, lines=((0.93, 0.01),), drift=0.02),
    "slot_lines_and_drift_no_angle": replace(
        _MANY, lines=((17.3, 0.03), (15.2, 0.02)), drift=0.003, harmonics=_SLOTS
    ),
}
FAMILIES = families_of(trial, RECORDS)
