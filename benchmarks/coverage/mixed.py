"""Families in which several disturbances meet, drawn up before any of them was scored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.channels import (
    Flux,
    Kind as Channel,
    Lines,
    Residual,
    Unbalance,
    trial as channel_trial,
)
from benchmarks.coverage.dynamic import Excited, Lag, Stepped, excited_trial, stepped_trial
from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

_QUIET = Disturbance()
STEADY: Mapping[str, Disturbance] = {
    "drift_and_ramp": replace(_QUIET, drift=0.03, amplitude_ramp=0.03, periods=72.6),
    "drift_and_ramp_no_angle": replace(_QUIET, drift=0.01, amplitude_ramp=-0.04, periods=53.1, angle=False,
        noise=3e-3),
    "swing_of_both": replace(_QUIET, swing=(0.01, 1.3), amplitude_swing=(0.02, 2.1), periods=66.4),
    "once_per_turn": replace(_QUIET, turns_Nm=(0.12, 0.06), frequency_Hz=163.0, periods=12.3),
    "once_per_turn_many_rows": replace(_QUIET, turns_Nm=(0.12, 0.06), noise=1e-4, periods=13.4),
    "once_per_turn_no_angle": replace(_QUIET, turns_Nm=(0.1, 0.05), frequency_Hz=163.0, periods=18.5,
        angle=False),
    "ramp_few_periods": replace(_QUIET, amplitude_ramp=0.06, noise=1e-4, periods=12.9),
    "ramp_few_periods_no_angle": replace(_QUIET, amplitude_ramp=-0.04, noise=1e-2, periods=13.7, angle=False),
    "ramp_and_swing_of_amplitude": replace(_QUIET, amplitude_ramp=-0.054, amplitude_swing=(0.0024, 2.1),
        noise=2e-3, periods=52.6),
    "amplitude_step_few_periods": replace(_QUIET, second_regime=1.016, noise=3e-3, periods=13.7),
    "amplitude_step_of_5": replace(_QUIET, second_regime=1.05, noise=1e-4, periods=43.7),
    "amplitude_step_long": replace(_QUIET, second_regime=0.95, noise=2e-4, periods=121.4, angle=False),
    "amplitude_step_small": replace(_QUIET, second_regime=1.006, noise=3e-3, periods=42.2),
    "bits_9_pink": replace(_QUIET, bits=9, noise=2e-3, kind="pink", periods=47.8),
    "bits_10_heavy": replace(_QUIET, bits=10, noise=3e-3, kind="heavy", frequency_Hz=31.9, periods=38.5),
    "bits_9_slow_no_angle": replace(_QUIET, bits=9, noise=2e-4, frequency_Hz=11.1, periods=14.8, angle=False),
    "clipped_slightly": replace(_QUIET, clip=0.985, noise=1e-2, periods=31.7),
    "decaying_dc_pink": replace(_QUIET, decay=(0.4, 0.15), noise=1e-2, kind="pink", periods=36.9),
    "interharmonic_pink_no_angle": replace(_QUIET, lines=((2.77, 0.01),), noise=1e-2, kind="pink",
        angle=False, periods=58.3),
    "amplitude_memory_swing": replace(_QUIET, amplitude_noise=(0.02, 0.6), swing=(0.005, 0.9), periods=91.2),
    "speed_walk_coloured": replace(_QUIET, speed_walk=0.003, noise=1e-2, colour=0.97, periods=64.9,
        angle=False),
    "wobble_slip_encoder": replace(_QUIET, wobble_rad=(4e-3, 1), slip=0.0004, counts=2048, periods=77.7,
        noise=3e-3),
    "ripple_noise_in_noise": replace(_QUIET, ripple_noise=(0.3, 0.3), noise=1e-2, periods=25.4),
    "ripple_memory_few_periods": replace(_QUIET, ripple_noise=(0.05, 0.9), periods=8.7, noise=1e-3),
    "ripple_noise_few_periods": replace(_QUIET, ripple_noise=(0.1, 0.0), periods=17.2, angle=False),
    "spikes_few_periods": replace(_QUIET, spikes=0.1, periods=8.3, noise=3e-3),
    "sawtooth_pink": replace(_QUIET, sawtooth=(0.1, 0.2), noise=1e-2, kind="pink", periods=44.1),
    "hum_few_periods": replace(_QUIET, frequency_Hz=36.1, lines=((50.0 / 36.1, 0.01),), periods=7.7,
        noise=1e-3),
    "seven_periods_popcorn": replace(_QUIET, periods=7.2, noise=1e-2, kind="popcorn"),
}  # fmt: skip
STEPPED: Mapping[str, Stepped] = {
    "step_clicks": Stepped(Lag(50.0, 0.5), 3e-3, kind="clicks"),
    "step_bits_10_pink": Stepped(Lag(90.0, 0.35), 3e-3, kind="pink", bits=10, held=True),
    "step_memory": Stepped(Lag(70.0), 1e-2, 0.998),
    "step_lag1_walk": Stepped(Lag(15.0), 1e-2, kind="walk"),
}
EXCITED: Mapping[str, Excited] = {
    "chirp_short": Excited(Lag(120.0, 0.5), "chirp", 1e-2, duration_s=0.5),
    "noise_short": Excited(Lag(90.0, 0.4), "noise", 1e-2, duration_s=0.6),
    "prbs_slow_noise": Excited(Lag(150.0), "prbs", 2e-2, colour=0.99),
}
CHANNELS: Mapping[str, Channel] = {
    "flux_few_bits_noise": Flux(revolutions=9.4, bits=9, noise=2e-3),
    "residual_slow": Residual(colour=0.998, ripple_Nm=0.03, periods=18.7),
    "unbalance_few_coloured": Unbalance(periods=6.3, colour=0.95),
    "unbalance_slow_amplitude": Unbalance(periods=61.8, amplitude_noise=(0.01, 0.6), noise=3e-3),
    "lines_in_colour": Lines(lines=((87.3, 0.08), (203.9, 0.03)), colour=0.9, duration_s=0.7),
}


FAMILIES = (
    *families_of(trial, STEADY),
    *families_of(stepped_trial, STEPPED),
    *families_of(excited_trial, EXCITED),
    *families_of(channel_trial, CHANNELS),
)
