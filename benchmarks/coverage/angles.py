"""Families of measured angles: speeds that wander by little, and errors of a resolver, alone and together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import POLE_PAIRS, Disturbance

_LITTLE = Disturbance(periods=61.3, speed_memory=(3e-5, 0.08))
# of a drive that switches at few places of a period: its harmonics reach far up
_SWITCHED = replace(
    _LITTLE,
    periods=4.5,
    frequency_Hz=10.0,
    speed_memory=(3e-3, 0.2),
    noise=0.05,
    harmonics={order: 0.03 for order in range(5, 400) if order % 2 and order % 3},
)
ANGLES: Mapping[str, Disturbance] = {
    "speed_wanders_little": _LITTLE,
    "speed_wanders_little_noise": replace(_LITTLE, angle_noise_rad=2e-4, noise=3e-3),
    "speed_wanders_resolver": replace(_LITTLE, wobble_rad=(1e-3, 1)),
    "speed_wanders_few_revolutions": replace(_LITTLE, periods=9.7, wobble_rad=(1e-3, 2)),
    "speed_wanders_slowly": replace(_LITTLE, speed_memory=(5e-5, 0.5), periods=33.4),
    "speed_wanders_switched": _SWITCHED,
    "speed_wanders_switched_counts": replace(_SWITCHED, counts=10_000),
    "swing_resolver_once_a_period": replace(
        _LITTLE, swing=(2e-3, 0.7), speed_memory=(0.0, 1.0), wobble_rad=(5e-3, POLE_PAIRS)
    ),
    "swing_resolver": replace(_LITTLE, swing=(2e-3, 0.9), speed_memory=(0.0, 1.0), wobble_rad=(3e-3, 2)),
    **{
        f"rotor_wobbles_encoder_{counts}": Disturbance(
            periods=100.3,
            swing=(0.01, Disturbance.frequency_Hz / POLE_PAIRS),
            counts=counts,
            noise=3e-3,
        )
        for counts in (60, 100, 360)
    },
}

FAMILIES = families_of(trial, ANGLES)
