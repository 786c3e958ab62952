"""Families in which disturbances meet that no other family combines, scored before anything was mended."""

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
    "clip_and_drift": replace(_QUIET, clip=0.97, drift=0.03, periods=47.3, noise=3e-3),
    "jitter_interharmonic": replace(_QUIET, time_jitter=0.03, lines=((2.63, 0.01),), periods=38.7),
    "jitter_fast": replace(_QUIET, time_jitter=0.1, frequency_Hz=133.0, periods=150.3),
    "decaying_dc_bits_12": replace(_QUIET, decay=(0.3, 0.15), bits=12, noise=3e-4, periods=44.4,
        frequency_Hz=23.3),
    "decaying_dc_heavy": replace(_QUIET, offset=0.1, decay=(0.3, 0.3), kind="heavy", noise=1e-2,
        periods=24.4),
    "reversal_pink": replace(_QUIET, reverses=True, noise=1e-2, kind="pink", periods=71.3),
    "speed_ramp_encoder": replace(_QUIET, drift=0.25, counts=4096, noise=1e-2, periods=60.3),
    "drift_encoder_720": replace(_QUIET, drift=0.06, counts=720, noise=2e-3, periods=50.3),
    "swing_encoder_512": replace(_QUIET, swing=(0.01, 2.7), counts=512, noise=2e-3, periods=70.3),
    "swing_30Hz_encoder_1000": replace(_QUIET, swing=(0.02, 27.7), counts=1000, noise=2e-3, periods=60.3),
    "swing_slip_encoder_1024": replace(_QUIET, slip=0.001, swing=(0.008, 1.7), counts=1024, noise=3e-3,
        periods=66.3),
    "swing_wobble_encoder_1024": replace(_QUIET, wobble_rad=(4e-3, 2), counts=1024, noise=2e-3,
        periods=61.3, swing=(0.003, 1.1)),
    "swing_wobble_3_encoder": replace(_QUIET, wobble_rad=(3e-3, 3), counts=2500, swing=(0.005, 1.3),
        periods=60.3, noise=2e-3),
    "drift_wobble_encoder_2048": replace(_QUIET, wobble_rad=(3e-3, 1), drift=0.04, noise=1e-2,
        periods=62.2, counts=2048),
    "amplitude_memory_short": replace(_QUIET, amplitude_noise=(0.02, 0.95), periods=30.3, noise=3e-3),
    "amplitude_memory_heavy": replace(_QUIET, amplitude_noise=(0.015, 0.8), noise=1e-2, kind="heavy",
        periods=120.6),
    "amplitude_memory_no_angle": replace(_QUIET, amplitude_noise=(0.01, 0.7), periods=90.3, noise=3e-3,
        angle=False),
    "amplitude_memory_interharmonic": replace(_QUIET, amplitude_noise=(0.01, 0.6), lines=((2.4, 0.01),),
        periods=60.3, noise=3e-3),
    "amplitude_ramp_bits_10": replace(_QUIET, amplitude_ramp=0.05, bits=10, periods=36.6),
    "amplitude_swing_bits_8": replace(_QUIET, bits=8, noise=2e-3, amplitude_swing=(0.03, 1.7),
        periods=55.2),
    "subharmonic": replace(_QUIET, lines=((0.5, 0.01), (1.5, 0.005)), periods=40.6),
    "chirp_bits_11": replace(_QUIET, chirp=(0.01, 1.2, 4.4), bits=11, periods=37.7),
    "ripple_noise_pink": replace(_QUIET, ripple_noise=(0.3, 0.8), noise=1e-2, kind="pink", periods=40.3),
}  # fmt: skip
_SECOND = Lag(60.0, 0.3)
STEPPED: Mapping[str, Stepped] = {
    "step_spikes": Stepped(_SECOND, 2e-3, spikes=(0.1, 5, 1)),
    "step_spikes_of_two": Stepped(_SECOND, 2e-3, spikes=(0.1, 5, 2)),
    "step_fast_ringing_spikes": Stepped(Lag(1900.0, 0.2), 2e-3, spikes=(0.1, 5, 1)),
    "step_ringing_in_three_rows": Stepped(Lag(3000.0, 0.2), 2e-3),
    "step_lag1_spikes": Stepped(Lag(40.0), 3e-3, spikes=(0.2, 4, 1)),
    "step_spikes_pink": Stepped(Lag(80.0, 0.5), 3e-3, kind="pink", duration_s=0.4, spikes=(0.1, 8, 1)),
    "step_delay_bits_11": Stepped(Lag(120.0, 0.6), 1e-3, delay_s=1.3e-3, bits=11),
    "step_faster_than_samples": Stepped(Lag(900.0), 3e-3),
    "step_bursts": Stepped(Lag(60.0, 0.5), 5e-3, kind="bursts"),
    "step_lag1_heavy_bits_9": Stepped(Lag(50.0), 5e-3, kind="heavy", bits=9),
    "pulse_from_silence": Stepped(Lag(60.0, 0.5), 5e-3, of_noise=(0.0, 1.0), pulse_s=0.1),
    "pulse_from_silence_held": Stepped(
        Lag(150.0), 3e-3, of_noise=(0.0, 1.0), gated=True, pulse_s=0.04, duration_s=0.09, held=True
    ),
    "step_of_noise_with_answer": Stepped(Lag(100.0), 1e-2, of_noise=(0.1, 1.0)),
    "step_into_calm": Stepped(Lag(100.0), 1e-2, of_noise=(1.0, 0.02)),
    "pulse_drift": Stepped(Lag(90.0, 0.5), 3e-3, pulse_s=0.09, drift=0.2),
    "ramp_bits_10": Stepped(Lag(100.0, 0.5), 2e-3, rise_s=0.01, bits=10),
}
EXCITED: Mapping[str, Excited] = {
    "multisine_three_periods": Excited(Lag(90.0, 0.15), "multisine", 1e-2, duration_s=0.6),
    "chirp_little_resonance": Excited(Lag(110.0, 0.65), "chirp", 1e-2),
    "multisine_bits_8": Excited(Lag(110.0, 0.5), "multisine", 1e-4, bits=8),
    "prbs_bits_8": Excited(Lag(220.0, 0.4), "prbs", 1e-4, duration_s=1.0, bits=8),
    "prbs_fast_bits_8": Excited(Lag(1200.0), "prbs", 1e-5, bits=8),
    "prbs_ringing_bits_8": Excited(Lag(3000.0, 0.1), "prbs", 1e-5, bits=8),
    "chirp_resonant_bits_9": Excited(Lag(80.0, 0.1), "chirp", 1e-3, bits=9),
}
CHANNELS: Mapping[str, Channel] = {
    "flux_drift_bits_9": Flux(drift=0.05, bits=9, revolutions=33.3),
    "flux_breathing_colour": Flux(breathing=(0.01, 0.9), colour=0.95, noise=5e-3, revolutions=60.3),
    "flux_breathing_short": Flux(breathing=(0.02, 0.9), revolutions=15.3),
    "unbalance_loud": Unbalance(negative=0.005, zero=0.002, noise=0.1, periods=18.3),
    "unbalance_bits_6": Unbalance(bits=6, noise=1e-3),
    "unbalance_memory_short": Unbalance(amplitude_noise=(0.02, 0.9), periods=25.3),
    "lines_bits_9_colour": Lines(bits=9, noise=5e-3, colour=0.9, duration_s=0.6),
    "residual_ripple_few_periods": Residual(ripple_Nm=0.05, colour=0.97, periods=5.3),
}


FAMILIES = (
    *families_of(trial, STEADY),
    *families_of(stepped_trial, STEPPED),
    *families_of(excited_trial, EXCITED),
    *families_of(channel_trial, CHANNELS),
)
