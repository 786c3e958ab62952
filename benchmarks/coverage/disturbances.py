"""Families of steady and less steady records: current, torque and angle, with disturbances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.families import Family
from benchmarks.coverage.steady import HARMONICS, Disturbance, trial

_QUIET = Disturbance()
_DRIFT = replace(_QUIET, periods=100.3, noise=1e-4)
DISTURBANCES: Mapping[str, Disturbance] = {
    "plain": _QUIET,
    "plain_no_angle": replace(_QUIET, angle=False),
    "white_-40dB": replace(_QUIET, noise=1e-2),
    "white_-40dB_no_angle": replace(_QUIET, noise=1e-2, angle=False),
    "white_-80dB": replace(_QUIET, noise=1e-4),
    "loud_white_-20dB": replace(_QUIET, noise=0.1),
    "non_integer_periods": replace(_QUIET, periods=23.37, noise=3e-3),
    "non_integer_no_angle": replace(_QUIET, periods=23.37, noise=3e-3, angle=False),
    "few_periods": replace(_QUIET, periods=4.6, noise=3e-3),
    "few_periods_no_angle": replace(_QUIET, periods=4.6, noise=3e-3, angle=False),
    "three_periods_interharmonic": replace(_QUIET, periods=3.4, noise=3e-3, lines=((2.3, 0.02),)),
    "many_periods": replace(_QUIET, periods=400.2, noise=1e-2, frequency_Hz=133.3),
    "fast_fundamental": replace(_QUIET, periods=300.4, noise=3e-3, frequency_Hz=401.3),
    "coloured": replace(_QUIET, noise=1e-2, colour=0.95),
    "strongly_coloured": replace(_QUIET, noise=1e-2, colour=0.998),
    "coloured_no_angle": replace(_QUIET, noise=1e-2, colour=0.98, angle=False),
    "drift_angle": replace(_DRIFT, drift=0.05),
    "drift_0.5_no_angle": replace(_DRIFT, drift=0.005, angle=False),
    "drift_8_no_angle": replace(_DRIFT, drift=0.08, angle=False),
    "drift_3_no_angle_noise": replace(_DRIFT, drift=0.03, angle=False, noise=1e-2, periods=60.7),
    "swing_2Hz_angle": replace(_DRIFT, swing=(0.01, 2.0)),
    "swing_2Hz_no_angle": replace(_DRIFT, swing=(0.01, 2.0), angle=False),
    "swing_7Hz_angle": replace(_DRIFT, swing=(0.01, 7.3), noise=1e-3),
    "swing_0.5Hz_no_angle": replace(_DRIFT, swing=(0.02, 0.5), angle=False, noise=1e-3),
    "swing_30Hz_angle": replace(_DRIFT, swing=(0.02, 31.7), noise=1e-3),
    "swing_encoder": replace(_DRIFT, swing=(0.005, 1.3), counts=10_000, noise=1e-3),
    "reversal": replace(_QUIET, reverses=True, periods=80.0),
    "reversal_no_angle": replace(_QUIET, reverses=True, periods=80.0, angle=False),
    "slip_0.3": replace(_QUIET, slip=0.003, periods=100.0),
    "slip_0.05": replace(_QUIET, slip=0.0005, periods=100.0),
    "slip_0.3_noise": replace(_QUIET, slip=0.003, periods=60.3, noise=1e-2),
    "encoder_1000": replace(_QUIET, counts=1000),
    "encoder_4096_noise": replace(_QUIET, counts=4096, noise=1e-2),
    "encoder_64": replace(_QUIET, counts=64, noise=3e-3),
    "angle_noise": replace(_QUIET, angle_noise_rad=2e-3),
    "wobble_1.48": replace(_QUIET, wobble_rad=(1.48e-3, 1), periods=80.0),
    "wobble_10": replace(_QUIET, wobble_rad=(1e-2, 1), periods=80.0),
    "wobble_3_order_2": replace(_QUIET, wobble_rad=(3e-3, 2), periods=80.0, noise=3e-3),
    "interharmonic": replace(_QUIET, lines=((3.37, 0.01),), noise=1e-3),
    "interharmonic_close": replace(_QUIET, lines=((1.18, 0.02),), noise=1e-3),
    "interharmonic_no_angle": replace(_QUIET, lines=((1.41, 0.02), (4.63, 0.01)), angle=False),
    "offset": replace(_QUIET, offset=0.2, noise=3e-3),
    "offset_no_angle": replace(_QUIET, offset=0.2, periods=17.4, noise=3e-3, angle=False),
    "decaying_dc": replace(_QUIET, decay=(0.5, 0.2), noise=1e-3),
    "decaying_dc_slow": replace(_QUIET, decay=(0.2, 0.7), periods=12.3),
    "decaying_dc_no_angle": replace(_QUIET, decay=(0.3, 0.1), periods=21.7, angle=False),
    "clipped": replace(_QUIET, clip=0.93, noise=1e-4),
    "clipped_hard": replace(_QUIET, clip=0.7),
    "bits_8": replace(_QUIET, bits=8, noise=1e-6),
    "bits_8_pure_sine": replace(_QUIET, bits=8, noise=0.0, harmonics={}),
    "bits_10_noise": replace(_QUIET, bits=10, noise=1e-3),
    "bits_12": replace(_QUIET, bits=12, noise=1e-4, frequency_Hz=19.37),
    "amplitude_noise": replace(_QUIET, amplitude_noise=(0.01, 0.0), periods=80.0),
    "amplitude_noise_memory": replace(_QUIET, amplitude_noise=(0.01, 0.9), periods=200.0),
    "ripple_noise": replace(_QUIET, ripple_noise=(0.2, 0.0), periods=80.0),
    "ripple_noise_memory": replace(_QUIET, ripple_noise=(0.2, 0.9), periods=200.0),
    "two_regimes": replace(_QUIET, second_regime=2.2),
    "two_regimes_no_angle": replace(_QUIET, second_regime=2.2, angle=False),
    "no_harmonics_noise": replace(_QUIET, harmonics={}, noise=1e-2),
    "low_distortion_noise": replace(_QUIET, harmonics={5: 0.001}, noise=1e-2),
    "standstill_current": replace(_QUIET, amplitude_A=0.0, noise=1e-2, harmonics={}),
    "no_mean_torque": replace(_QUIET, torque_Nm=0.0, noise=1e-2),
    "little_mean_torque": replace(_QUIET, torque_Nm=0.004, noise=1e-2),
    "jittered_samples": replace(_QUIET, time_jitter=0.05),
    "spikes": replace(_QUIET, spikes=0.3),
    "white_-60dB_long": replace(_QUIET, noise=1e-3, periods=250.6, frequency_Hz=50.0),
    # components above half the rate alias, which no analysis can detect
    "few_samples_a_period": replace(
        _QUIET, noise=3e-3, periods=500.3, frequency_Hz=811.7, harmonics={5: HARMONICS[5]}
    ),
    "two_periods": replace(_QUIET, periods=2.9, noise=3e-3),
    "six_periods_coloured": replace(_QUIET, periods=6.45, noise=1e-2, colour=0.98, angle=False),
    "standstill_within": replace(_QUIET, stands_still=0.1, periods=80.0),
    "standstill_within_no_angle": replace(_QUIET, stands_still=0.06, periods=80.0, angle=False),
    "phase_step": replace(_QUIET, phase_step_rad=0.6),
    "phase_step_no_angle": replace(_QUIET, phase_step_rad=0.6, angle=False),
    "offset_and_interharmonic": replace(_QUIET, offset=0.3, lines=((2.61, 0.01),), periods=31.3, noise=3e-3),
    "decaying_dc_fast": replace(_QUIET, decay=(1.0, 0.03), periods=60.2),
    "swing_and_interharmonic": replace(_DRIFT, swing=(0.01, 3.1), lines=((1.63, 0.01),), noise=1e-3),
    "swing_coloured_no_angle": replace(_DRIFT, swing=(0.005, 1.1), noise=1e-2, colour=0.95, angle=False),
    "drift_encoder": replace(_DRIFT, drift=0.04, counts=4096, noise=1e-3),
    "wobble_and_noise": replace(_QUIET, wobble_rad=(5e-3, 1), angle_noise_rad=1e-3, periods=80.0, noise=3e-3),
    "bits_6": replace(_QUIET, bits=6, noise=1e-3),
    "bits_8_drift": replace(_DRIFT, bits=8, drift=0.01, noise=1e-3),
    "bits_10_fast": replace(_QUIET, bits=10, noise=1e-4, frequency_Hz=133.3, periods=200.4),
    "bits_16": replace(_QUIET, bits=16, noise=1e-5),
    **{
        f"bits_{bits}_{noise:g}": replace(_QUIET, bits=bits, noise=noise, frequency_Hz=21.7, periods=33.3)
        for bits in (12, 14, 16, 18)
        for noise in (1e-6, 1e-5, 1e-4)
    },
    "ripple_noise_some_memory": replace(_QUIET, ripple_noise=(0.1, 0.6), periods=60.0),
    "beside_the_fifth": replace(_QUIET, lines=((4.87, 0.01), (5.16, 0.006)), periods=37.4),
    "beside_the_fifth_no_angle": replace(_QUIET, lines=((4.93, 0.01), (5.04, 0.004)), periods=61.7, angle=False),
    "settling": replace(_DRIFT, settling=(0.04, 0.15), noise=1e-3),
    "settling_no_angle": replace(_DRIFT, settling=(0.03, 0.2), noise=1e-3, angle=False),
    "settling_fast_no_angle": replace(_QUIET, settling=(0.05, 0.06), periods=50.4, angle=False),
    "speed_walk": replace(_DRIFT, speed_walk=0.004, noise=1e-3, counts=10_000),
    "speed_walk_no_angle": replace(_DRIFT, speed_walk=0.004, noise=1e-3, angle=False),
    "speed_memory_no_angle": replace(_DRIFT, speed_memory=(0.003, 0.03), noise=3e-3, angle=False),
    "speed_memory_fast": replace(_DRIFT, speed_memory=(0.005, 0.004), noise=3e-3, counts=4096),
    "pink": replace(_QUIET, noise=1e-2, kind="pink"),
    "pink_no_angle": replace(_QUIET, noise=1e-2, kind="pink", angle=False, periods=23.7),
    "heavy": replace(_QUIET, noise=1e-2, kind="heavy"),
    "bursts": replace(_QUIET, noise=1e-2, kind="bursts", periods=55.3),
    "bits_7_dither": replace(_QUIET, bits=7, noise=8e-3),
    "bits_7": replace(_QUIET, bits=7, noise=1e-4, frequency_Hz=23.7, periods=31.4),
    "bits_8_no_angle": replace(_QUIET, bits=8, noise=3e-4, angle=False, frequency_Hz=17.3, periods=24.2),
    "bits_9_swing": replace(_DRIFT, bits=9, noise=1e-4, swing=(0.01, 1.7)),
    "sawtooth": replace(_QUIET, sawtooth=(0.2, 0.08), periods=60.3),
    "sawtooth_even": replace(_QUIET, sawtooth=(0.2, 0.0), noise=1e-2, frequency_Hz=27.3),
    "wobble_2x": replace(_QUIET, wobble_rad=(6e-3, 2), periods=80.0, noise=1e-3),
    "wobble_5_fast": replace(_QUIET, wobble_rad=(2e-3, 5), periods=120.4, noise=3e-3, frequency_Hz=93.1),
    "amplitude_swing": replace(_QUIET, amplitude_swing=(0.02, 3.3), periods=40.0),
    "amplitude_swing_no_angle": replace(_QUIET, amplitude_swing=(0.03, 1.3), periods=52.6, angle=False, noise=3e-3),
    "amplitude_ramp": replace(_QUIET, amplitude_ramp=0.05, periods=40.0),
    "strong_harmonics": replace(_QUIET, harmonics={5: 0.2, 7: 0.12, 11: 0.08, 13: 0.06}, noise=3e-3, angle=False),
    "even_harmonics": replace(_QUIET, harmonics={2: 0.02, 3: 0.01, 5: 0.03}, noise=3e-3, periods=9.4),
    "hum": replace(_QUIET, frequency_Hz=47.3, lines=((50.0 / 47.3, 0.01), (150.0 / 47.3, 0.004)), periods=60.4),
    "drift_interharmonics": replace(_DRIFT, drift=0.02, lines=((0.37, 0.01), (2.71, 0.01)), noise=1e-3, angle=False),
    "drift_pink": replace(_DRIFT, drift=-0.03, noise=1e-2, kind="pink", counts=2048),
    "few_samples_drift": replace(_DRIFT, frequency_Hz=611.3, harmonics={5: 0.03}, periods=400.7, drift=0.01, noise=3e-3),
}  # fmt: skip


def _family(name: str, what: Disturbance) -> Family:
    return Family(name, lambda random: trial(what, random))


FAMILIES = tuple(_family(name, what) for name, what in DISTURBANCES.items())
