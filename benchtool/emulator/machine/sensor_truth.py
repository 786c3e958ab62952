"""True values of the emulated sensors, which control never sees, and their form for the kernel."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchtool.emulator.machine.encoder import Counter, Eccentricity, Encoder
from benchtool.emulator.machine.sampling import Sampling, sampling_of
from benchtool.emulator.machine.sensors import Drift, Sensing, VoltageLag
from benchtool.emulator.machine.shunts import Shunts
from benchtool.emulator.machine.truth import finite, not_negative, positive
from benchtool.errors import ValueRefused


@dataclass(frozen=True, kw_only=True)
class CurrentTruth:
    """The sensor of one phase.

    It reads (gain + gain_drift_per_K w) times the current, which it follows with a first-order lag and a
    delay, plus offset_A + offset_drift_A_K w and noise, where w is how far it has warmed up. `noise_A_rms`
    is that of all phases where it is None. `stuck_A` is what it reads whatever the current, without noise.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    gain: float = 1.0
    offset_A: float = 0.0
    noise_A_rms: float | None = None
    gain_drift_per_K: float = 0.0
    offset_drift_A_K: float = 0.0
    bandwidth_Hz: float | None = None
    delay_s: float = 0.0
    stuck_A: float | None = None

    def __post_init__(self) -> None:
        finite(
            gain=self.gain,
            offset_A=self.offset_A,
            gain_drift_per_K=self.gain_drift_per_K,
            offset_drift_A_K=self.offset_drift_A_K,
            stuck_A=self.stuck_A or 0.0,
        )
        not_negative(noise_A_rms=self.noise_A_rms or 0.0, delay_s=self.delay_s)
        if self.bandwidth_Hz is not None:
            positive(bandwidth_Hz=self.bandwidth_Hz)

    @property
    def line(self) -> tuple[float, float]:
        """Gain and offset of what it reads; without a gain where it is stuck."""
        return (self.gain, self.offset_A) if self.stuck_A is None else (0.0, self.stuck_A)

    @property
    def drift(self) -> tuple[float, float]:
        """Changes of gain and offset per kelvin."""
        return (self.gain_drift_per_K, self.offset_drift_A_K) if self.stuck_A is None else (0.0, 0.0)

    @property
    def omega(self) -> float:
        """Its corner frequency in rad/s; infinite without a lag."""
        return math.inf if self.bandwidth_Hz is None else 2.0 * math.pi * self.bandwidth_Hz

    def rms(self, common_A: float) -> float:
        """Return the standard deviation of its noise, where that of all phases is `common_A`."""
        if self.stuck_A is not None:
            return 0.0
        return common_A if self.noise_A_rms is None else self.noise_A_rms


@dataclass(frozen=True, kw_only=True)
class VoltageTruth:
    """The sensor of the dc link; as `CurrentTruth`.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    gain: float = 1.0
    offset_V: float = 0.0
    noise_V_rms: float = 0.0
    bandwidth_Hz: float | None = None
    stuck_V: float | None = None

    def __post_init__(self) -> None:
        finite(gain=self.gain, offset_V=self.offset_V, stuck_V=self.stuck_V or 0.0)
        not_negative(noise_V_rms=self.noise_V_rms)
        if self.bandwidth_Hz is not None:
            positive(bandwidth_Hz=self.bandwidth_Hz)

    @property
    def line(self) -> tuple[float, float]:
        """Gain and offset of what it reads; without a gain where it is stuck."""
        return (self.gain, self.offset_V) if self.stuck_V is None else (0.0, self.stuck_V)

    @property
    def rms(self) -> float:
        """The standard deviation of its noise."""
        return self.noise_V_rms if self.stuck_V is None else 0.0

    def lag(self, T_s: float) -> VoltageLag | None:
        """Return its lag for a control period of `T_s` seconds, over which the voltage holds."""
        if self.bandwidth_Hz is None:
            return None
        return VoltageLag(-math.expm1(-2.0 * math.pi * self.bandwidth_Hz * T_s))


@dataclass(frozen=True, kw_only=True)
class EncoderTruth:
    """Flaws of the encoder; the angles are mechanical.

    `slip` is the part of the shaft's angle by which the disc stays behind. `stuck` has the counts end, as
    with a cable that is pulled.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    reversed: bool = False
    relative: bool = False
    index: bool = False
    lost_every: int = 0
    slip: float = 0.0
    eccentricity_1_rad: float = 0.0
    eccentricity_1_phase_rad: float = 0.0
    eccentricity_2_rad: float = 0.0
    eccentricity_2_phase_rad: float = 0.0
    stuck: bool = False

    def __post_init__(self) -> None:
        finite(
            slip=self.slip,
            eccentricity_1_phase_rad=self.eccentricity_1_phase_rad,
            eccentricity_2_phase_rad=self.eccentricity_2_phase_rad,
        )
        not_negative(
            lost_every=self.lost_every,
            eccentricity_1_rad=self.eccentricity_1_rad,
            eccentricity_2_rad=self.eccentricity_2_rad,
        )

    @property
    def turn(self) -> float:
        """Angle of the disc per angle of the shaft."""
        return 0.0 if self.stuck else 1.0 - self.slip

    def encoder(self, lines: int, zero_rad: float) -> Encoder:
        """Return the coefficients of an encoder with so many lines whose disc is at `zero_rad` with the
        shaft at zero."""
        eccentricity = counter = None
        if self.eccentricity_1_rad > 0.0 or self.eccentricity_2_rad > 0.0:
            eccentricity = Eccentricity(
                self.eccentricity_1_rad,
                self.eccentricity_1_phase_rad,
                self.eccentricity_2_rad,
                self.eccentricity_2_phase_rad,
            )
        if self.relative or self.index or self.lost_every > 0:
            counter = Counter(self.relative, self.index, self.lost_every)
        edges = -4 * lines if self.reversed else 4 * lines
        return Encoder(edges, self.turn, zero_rad, eccentricity, counter)


@dataclass(frozen=True, kw_only=True)
class SensorTruth:
    """Current, voltage and position measurement.

    Currents are converted with `adc_bits` over +-`i_full_scale_A`, the dc link with as many bits over 0 to
    `u_full_scale_V`. `current_noise_A_rms` is of a phase that states none of its own. `sampling_point` is
    where in the PWM period the currents are read; 1 is its end, where the control tick is. With
    `shunt_settling_s` they are read by shunts in the lower legs. The current sensors warm up by `warm_up_K`
    with the time constant `warm_up_s`.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    i_full_scale_A: float
    u_full_scale_V: float
    adc_bits: int = 10
    current_noise_A_rms: float = 0.0
    sampling_point: float = 1.0
    shunt_settling_s: float | None = None
    warm_up_K: float = 0.0
    warm_up_s: float = 600.0
    encoder_lines: int = 2500
    encoder_offset_rad: float = 0.0
    i_a: CurrentTruth = CurrentTruth()
    i_b: CurrentTruth = CurrentTruth()
    i_c: CurrentTruth = CurrentTruth()
    u_dc: VoltageTruth = VoltageTruth()
    encoder: EncoderTruth = EncoderTruth()

    def __post_init__(self) -> None:
        positive(
            i_full_scale_A=self.i_full_scale_A,
            u_full_scale_V=self.u_full_scale_V,
            adc_bits=self.adc_bits,
            encoder_lines=self.encoder_lines,
            warm_up_s=self.warm_up_s,
        )
        not_negative(current_noise_A_rms=self.current_noise_A_rms)
        finite(encoder_offset_rad=self.encoder_offset_rad, warm_up_K=self.warm_up_K)
        if not 0.0 <= self.sampling_point <= 1.0:
            raise ValueRefused(f"sampling_point = {self.sampling_point:g}: give a part of the period, 0 to 1")
        if self.shunt_settling_s is not None:
            self._require_shunts_alone(self.shunt_settling_s)

    def _require_shunts_alone(self, settling_s: float) -> None:
        positive(shunt_settling_s=settling_s)
        for phase in self.phases:
            if phase.bandwidth_Hz is not None or phase.delay_s > 0.0:
                raise ValueRefused(
                    "shunt_settling_s with bandwidth_Hz or delay_s of a current sensor: leave these out, the "
                    "settling time is that of the shunt's amplifier"
                )

    @property
    def phases(self) -> tuple[CurrentTruth, CurrentTruth, CurrentTruth]:
        """The sensors of phases a, b and c."""
        return self.i_a, self.i_b, self.i_c

    @property
    def noise_rms(self) -> tuple[float, float, float, float]:
        """The noise of phases a, b and c in A, and of the dc link in V."""
        a, b, c = (phase.rms(self.current_noise_A_rms) for phase in self.phases)
        return a, b, c, self.u_dc.rms

    def sensing(self, T_s: float, dead_time_s: float = 0.0) -> Sensing:
        """Return the coefficients of the measurement for a control period of `T_s` seconds."""
        codes = 2.0**self.adc_bits
        (gain_a, offset_a), (gain_b, offset_b), (gain_c, offset_c) = (phase.line for phase in self.phases)
        gain_u, offset_u = self.u_dc.line
        shunts = None
        if self.shunt_settling_s is not None:
            shunts = Shunts(self.shunt_settling_s + dead_time_s, self.sampling_point * T_s)
        return Sensing(
            gain_a=gain_a,
            gain_b=gain_b,
            gain_c=gain_c,
            offset_a=offset_a,
            offset_b=offset_b,
            offset_c=offset_c,
            gain_u=gain_u,
            offset_u=offset_u,
            i_step=2.0 * self.i_full_scale_A / codes,
            half_codes=codes / 2.0,
            u_step=self.u_full_scale_V / codes,
            encoder=self.encoder.encoder(self.encoder_lines, self.encoder_offset_rad),
            drift=self._drift(T_s),
            shunts=shunts,
            u_lag=self.u_dc.lag(T_s),
        )

    def _drift(self, T_s: float) -> Drift | None:
        (gain_a, offset_a), (gain_b, offset_b), (gain_c, offset_c) = (phase.drift for phase in self.phases)
        if self.warm_up_K == 0.0 or not any((gain_a, gain_b, gain_c, offset_a, offset_b, offset_c)):
            return None
        share = -math.expm1(-T_s / self.warm_up_s)
        return Drift(gain_a, gain_b, gain_c, offset_a, offset_b, offset_c, self.warm_up_K, share)

    def sampling(self, T_s: float) -> Sampling | None:
        """Return how the currents are read within a control period of `T_s` seconds.

        Raises:
            ValueRefused: one is read more than two periods late.
        """
        early = (1.0 - self.sampling_point) * T_s
        for name, phase in zip("abc", self.phases, strict=True):
            if not early + phase.delay_s < 2.0 * T_s:
                raise ValueRefused(
                    f"delay_s = {phase.delay_s:g} of phase {name} with sampling_point = "
                    f"{self.sampling_point:g}: the current at a control tick would be older than two PWM "
                    f"periods of {T_s:g} s; shorten the delay"
                )
        a, b, c = self.phases
        return sampling_of(
            T_s,
            (early + a.delay_s, early + b.delay_s, early + c.delay_s),
            (a.omega, b.omega, c.omega),
        )


def going_on(before: Encoder, after: Encoder, theta_m: float, moved_rad: float) -> Encoder:
    """Return an encoder in the place of another while the shaft is at `theta_m`.

    Its disc is where the other one's is, but for `moved_rad`, and what the other one has miscounted stays.
    """
    if before.turn != after.turn:
        moved_rad += theta_m * (before.turn - after.turn)
    counter = after.counter
    if counter is None and before.counter is not None:
        counter = before.counter._replace(lost_every=0)
    return after._replace(zero=before.zero + moved_rad, counter=counter)
