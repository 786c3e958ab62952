"""Families of two or three disturbances at once, with few periods or slow noise, drawn up before any was
scored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from benchmarks.coverage.channels import (
    Flux,
    Kind as Channel,
    Lines,
    Unbalance,
    trial as channel_trial,
)
from benchmarks.coverage.dynamic import Excited, Lag, Stepped, excited_trial, stepped_trial
from benchmarks.coverage.families import families_of
from benchmarks.coverage.steady import trial
from benchmarks.coverage.steady_records import Disturbance

_QUIET = Disturbance()
STEADY: Mapping[str, Disturbance] = {
    "swing_bits_9_silent": replace(_QUIET, swing=(0.01, 2.0), bits=9, noise=1e-6, periods=80.0),
    "swing_bits_9_few_periods": replace(_QUIET, swing=(0.006, 1.1), bits=9, noise=1e-3, periods=9.7),
    "swing_bits_11_no_angle": replace(_QUIET, swing=(0.004, 0.8), bits=11, periods=64.2, angle=False),
    "coloured_-40dB_three_periods": replace(_QUIET, noise=1e-2, colour=0.98, periods=3.8),
    "coloured_-60dB_five_periods": replace(_QUIET, noise=1e-3, colour=0.99, periods=5.2, angle=False),
    "coloured_-80dB_four_periods": replace(_QUIET, noise=1e-4, colour=0.95, periods=4.4),
    "jitter_swing_encoder_2000": replace(_QUIET, time_jitter=0.05, swing=(0.004, 1.6), counts=2000,
        noise=2e-3, periods=52.6),
    "regimes_bits_10_drift": replace(_QUIET, second_regime=1.3, bits=10, drift=0.02, noise=1e-3,
        periods=48.9),
    "slip_wobble_pink": replace(_QUIET, slip=0.0008, wobble_rad=(3e-3, 1), noise=5e-3, kind="pink",
        periods=58.1),
    "clip_interharmonic_pink": replace(_QUIET, clip=0.98, lines=((3.3, 0.01),), noise=3e-3, kind="pink",
        periods=41.3),
    "bounded_bits_10": replace(_QUIET, noise=5e-3, kind="bounded", bits=10, periods=46.6),
    "bounded_few_periods": replace(_QUIET, noise=1e-2, kind="bounded", periods=12.4),
    "skewed_drift": replace(_QUIET, noise=1e-2, kind="skewed", drift=0.03, periods=39.5),
    "decaying_dc_swing": replace(_QUIET, decay=(0.3, 0.2), swing=(0.005, 1.2), noise=3e-3, periods=55.7),
    "offset_coloured_standstill": replace(_QUIET, offset=0.05, stands_still=0.05, noise=5e-3, colour=0.9,
        periods=36.4),
    "reversal_encoder_1024": replace(_QUIET, reverses=True, counts=1024, noise=3e-3, periods=62.7),
    "interharmonic_beside_three_periods": replace(_QUIET, lines=((4.7, 0.015),), noise=3e-3, periods=3.6),
}  # fmt: skip
STEPPED: Mapping[str, Stepped] = {
    "step_soft_bits_9_coloured": Stepped(Lag(90.0, 0.7), 3e-3, 0.9, bits=9),
    "step_underdamped_pink": Stepped(Lag(120.0, 0.2), 5e-3, kind="pink", held=True),
    "step_bounded_down": Stepped(Lag(70.0, 0.5), 2e-2, kind="bounded", height=-3.0),
    "pulse_bits_10_popcorn": Stepped(Lag(100.0), 3e-3, kind="popcorn", bits=10, pulse_s=0.1),
    "step_skewed": Stepped(Lag(55.0, 0.45), 1e-2, kind="skewed"),
}
EXCITED: Mapping[str, Excited] = {
    "chirp_bits_10_coloured": Excited(Lag(130.0, 0.4), "chirp", 1e-2, colour=0.9, bits=10),
    "noise_lag2_delayed": Excited(Lag(140.0, 0.5), "noise", 2e-2, delay_s=3e-4),
}
CHANNELS: Mapping[str, Channel] = {
    "flux_swing_bits_10": Flux(swing=(0.01, 3.3), bits=10, noise=1e-3, revolutions=36.4),
    "flux_line_coloured": Flux(line=(2.6, 5e-3), colour=0.9, noise=3e-3, revolutions=28.2),
    "unbalance_bits_9_drift": Unbalance(bits=9, drift=0.02, noise=2e-3, periods=33.8),
    "unbalance_line_few_periods": Unbalance(line=0.01, noise=3e-3, periods=8.7),
    "lines_three_bits_10": Lines(lines=((97.1, 0.1), (141.3, 0.06), (233.9, 0.04)), bits=10, noise=1e-2),
}


FAMILIES = (
    *families_of(trial, STEADY),
    *families_of(stepped_trial, STEPPED),
    *families_of(excited_trial, EXCITED),
    *families_of(channel_trial, CHANNELS),
)
