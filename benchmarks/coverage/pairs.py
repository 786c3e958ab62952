"""Families of two disturbances at once: of eighty that were drawn up before any was scored, those that tell
most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.channels import (
    Flux,
    Kind as Channel,
    Switching,
    Unbalance,
    trial as channel_trial,
)
from benchmarks.coverage.dynamic import Excited, Lag, Stepped, excited_trial, stepped_trial
from benchmarks.coverage.families import families_of
from benchmarks.coverage.stamps import Stamps, trial as stamps_trial
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

_QUIET = Disturbance()
STEADY: Mapping[str, Disturbance] = {
    "swing_and_bits_10": replace(_QUIET, swing=(0.008, 2.4), bits=10, noise=3e-4, periods=57.7),
    "slip_and_noise": replace(_QUIET, slip=0.0015, noise=3e-2, periods=45.3),
    "clip_and_interharmonic": replace(_QUIET, clip=0.96, lines=((2.71, 0.02),), periods=42.4),
    "regimes_few_periods": replace(_QUIET, second_regime=1.5, periods=6.4),
    "regimes_slight_few_periods": replace(_QUIET, second_regime=1.04, periods=8.6, noise=3e-3),
    "standstill_noise_no_angle": replace(_QUIET, stands_still=0.03, noise=3e-2, periods=50.3, angle=False),
    "standstill_current_pink": replace(_QUIET, amplitude_A=0.0, noise=3e-2, harmonics={}, kind="pink"),
    "decay_few_periods": replace(_QUIET, decay=(0.4, 0.25), periods=5.7, noise=3e-3),
    "decay_few_periods_no_angle": replace(_QUIET, decay=(0.3, 0.2), periods=7.3, noise=3e-3, angle=False),
    "reversal_no_angle_noise": replace(_QUIET, reverses=True, noise=3e-2, periods=40.3, angle=False),
    "reversal_no_angle_bits_9": replace(_QUIET, reverses=True, bits=9, noise=1e-3, periods=30.7,
        angle=False),
    "drift_few_periods": replace(_QUIET, drift=0.06, periods=6.7, noise=3e-3, angle=False),
    "interharmonic_few_periods_no_angle": replace(_QUIET, lines=((1.6, 0.02),), periods=7.8, angle=False),
    "wobble_2_drift": replace(_QUIET, wobble_rad=(3e-3, 2), drift=0.05, periods=58.3),
    "wobble_few_revolutions": replace(_QUIET, wobble_rad=(5e-3, 1), periods=9.3, noise=3e-3),
    "wobble_swing": replace(_QUIET, wobble_rad=(3e-3, 1), swing=(0.005, 1.4), periods=72.6, noise=3e-3),
    "encoder_256_few_periods": replace(_QUIET, counts=256, periods=8.4, noise=3e-3),
    "encoder_500_swing_fast": replace(_QUIET, counts=500, swing=(0.015, 6.1), periods=63.8, noise=3e-3),
    "alternating": replace(_QUIET, alternates=0.02, periods=40.0),
    "alternating_drift": replace(_QUIET, alternates=0.03, drift=0.03, periods=55.3, noise=3e-3),
    "frozen": replace(_QUIET, frozen=60, periods=40.3),
    "frozen_noise": replace(_QUIET, frozen=25, noise=1e-2, periods=30.3),
    "fractional_swing": replace(_QUIET, noise=1e-2, kind="fractional", swing=(0.005, 1.1), periods=39.7),
    "amplitude_memory_few_periods": replace(_QUIET, amplitude_noise=(0.02, 0.8), periods=12.3),
    "amplitude_memory_drift": replace(_QUIET, amplitude_noise=(0.01, 0.95), drift=0.02, periods=80.3),
    "two_periods_bits_9": replace(_QUIET, periods=2.6, bits=9, noise=2e-3),
}  # fmt: skip
STAMPED: Mapping[str, Stamps] = {
    "gap_and_drift": Stamps(lost=(1, 60), drift=0.04, noise=3e-3),
    "gaps_and_encoder": Stamps(lost=(8, 20), counts=1024, swing=(0.005, 1.3), periods=50.3),
    "jitter_and_wobble": Stamps(jitter=0.2, wobble_rad=(4e-3, 1), periods=55.3),
    "jitter_and_interharmonic": Stamps(jitter=0.05, line=(2.43, 0.01)),
    "resolution_and_swing": Stamps(resolution_s=2e-6, swing=(0.01, 1.7), periods=50.6),
}
STEPPED: Mapping[str, Stepped] = {
    "step_ripple_bits_8": Stepped(Lag(70.0, 0.4), 2e-3, ripple=(0.02, 300.0), bits=8),
    "step_ripple_bits_6": Stepped(Lag(50.0), 1e-3, ripple=(0.03, 170.0), bits=6, held=True),
    "step_drift_bits_8": Stepped(Lag(60.0, 0.5), 2e-3, drift=0.2, bits=8),
    "step_delay_pink": Stepped(Lag(90.0, 0.4), 5e-3, kind="pink", delay_s=2e-3),
    "step_down_bits_7_heavy": Stepped(Lag(60.0, 0.6), 5e-3, height=-1.5, kind="heavy", bits=7),
}
EXCITED: Mapping[str, Excited] = {
    "chirp_drift_coloured": Excited(Lag(100.0, 0.6), "chirp", 1e-2, colour=0.95, drift=0.5),
    "noise_bits_8_drift": Excited(Lag(120.0, 0.5), "noise", 1e-3, bits=8, drift=0.3),
}
CHANNELS: Mapping[str, Channel] = {
    "flux_interharmonic_few": Flux(line=(2.37, 0.01), revolutions=9.3),
    "flux_breathing_drift": Flux(breathing=(0.01, 0.8), drift=0.04, revolutions=60.3),
    "switching_modulated_short": Switching(modulation=(0.3, 13.0), duration_s=0.2),
    "switching_modulated_irregular": Switching(modulation=(0.2, 7.3), scatter=0.2, duration_s=0.5),
    "unbalance_drift_coloured": Unbalance(drift=0.04, colour=0.95, periods=40.3),
    "unbalance_bits_8_line": Unbalance(bits=8, line=0.01, noise=1e-3, periods=33.3),
}


FAMILIES = (
    *families_of(trial, STEADY),
    *families_of(stamps_trial, STAMPED),
    *families_of(stepped_trial, STEPPED),
    *families_of(excited_trial, EXCITED),
    *families_of(channel_trial, CHANNELS),
)
