"""Families whose fundamental alone has sidebands, as of a slip, or whose speed wanders over many periods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import Disturbance, trial

_QUIET = Disturbance()
_MANY = replace(_QUIET, periods=118.3, angle=False)
RECORDS: Mapping[str, Disturbance] = {
    "slip_sidebands": replace(_QUIET, lines=((0.93, 0.012), (1.07, 0.028)), periods=60.4),
    "slip_sidebands_no_angle": replace(
        _QUIET, lines=((0.94, 0.03), (1.06, 0.015)), angle=False, periods=75.7
    ),
    "one_sideband": replace(_QUIET, lines=((0.57, 0.02),), periods=50.0),
    "drift_many_periods_no_angle": replace(_MANY, drift=0.006),
    "swing_many_periods_no_angle": replace(_MANY, swing=(0.004, 0.9)),
    "speed_memory_many_periods_no_angle": replace(_MANY, speed_memory=(0.003, 0.05), periods=113.6),
}
FAMILIES = families_of(trial, RECORDS)
