"""Direction, pole pairs and offset of the encoder, by a current vector that drags the rotor round."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from benchtool.analysis import Basis, Contribution, Measurement, Uncertainty, combined
from benchtool.block import Block
from benchtool.commission.estimators.alignment import Alignment, Motion, Spin, alignment, motion
from benchtool.commission.estimators.vectors import vector_of
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus
from benchtool.errors import SetUpError
from benchtool.protocol.dictionary import Value

_SHARE = 0.6  # of the rated current
_OF_SWING = 1.6  # electrical speed over the frequency of the swing about the current
_ACCELERATION = 0.05  # over the square of that frequency
_OF_RATED = 0.25  # of the rated speed, at most
_SPUN_S, _MOST_TURNS = 1.0, 8
_STIFF = 5.0  # bandwidth of the current loop over the electrical speed
_ALIGN_S = 0.8
_REVOLUTIONS = 1.02
_ROWS = 4000
_LEFT_OUT_RAD = 0.003  # electrical, decision 0119
_EMF_SEEN = 0.3  # of the nameplate's rotor flux: above it a rotor has turned
_HARDLY = 0.1  # of the motion expected
_WHOLE_NUMBER, _SURE = 0.004, 4.0
_NEAREST = 0.25  # of a pole pair: further off none is nearest
_ECCENTRIC_RAD = math.radians(1.3)
_LOADED_RAD = math.radians(25.0)
_SLIPS_RAD = 0.9
_ALIKE = 0.5 / math.tan(0.025 * math.pi)  # mean over difference of equal swings, beyond which 5 % are alike
_LEAP_RAD = 0.05
_TOO_FAST = 0x84  # class of the error codes for a speed


class DraggedRotor:
    """Drag the rotor round by a current vector, a revolution one way and back again."""

    name = "encoder"
    needs: tuple[str, ...] = ("resistance",)
    sets: tuple[str, ...] = ("encoder_direction", "pole_pairs", "encoder_offset")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a revolution in each direction, or as far as the shaft may turn."""
        spin = _Turning.of(known)
        stride = max(1, math.ceil(spin.duration_s / (_ROWS * known.control_period_s)))
        rows = math.floor(spin.duration_s / (stride * known.control_period_s)) - 1
        p = known.motor.pole_pairs
        stiff = max(_STIFF * spin.omega_e_rad_s, known.damping_bandwidth_rad_s)
        stiff = min(stiff, 0.1 / known.control_period_s)
        held: dict[str, Value] = {
            "omega_current": stiff,
            "dead_time_compensation": 0.0,
            "encoder_offset": 0.0,
            "encoder_direction": "forward",
            **known.offsets,
            **known.electrical,
        }
        amplitude_A = _SHARE * known.I_N_A
        align = Excitation(
            "alignment",
            Stimulus(quantity="current", shape="ramp", amplitude_A=amplitude_A, duration_s=_ALIGN_S),
            CaptureRequest(CURRENTS, rows=10),
            amplitude_A**2 * _ALIGN_S / 3.0,
            held,
        )
        turns = (
            Excitation(
                f"turning {way} at {sense * spin.omega_e_rad_s / p:.3g} rad/s",
                Stimulus(
                    quantity="current",
                    shape="constant",
                    amplitude_A=amplitude_A,
                    duration_s=spin.duration_s,
                    angle_rad=begin % (2.0 * math.pi),
                    omega_e_rad_s=sense * spin.omega_e_rad_s,
                    turn_s=spin.lead_s,
                ),
                CaptureRequest((*CURRENTS, "u_alpha", "u_beta", "theta_m"), rows=rows, stride=stride),
                amplitude_A**2 * spin.duration_s,
                held,
            )
            for way, sense, begin in (("on", 1, 0.0), ("back", -1, spin.end_rad))
        )
        return (align, *turns)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `pole_pairs`, `encoder_direction`, `encoder_offset`, and the encoder's error in a
        revolution.

        Raises:
            AnalysisError: the captures do not define them.
            SetUpError: the rotor or the encoder does not turn, or the encoder does not fit the motor.
        """
        blocks = blocks[1:]  # not the alignment
        spins = [_spin(block, known, sense) for block, sense in zip(blocks, (1, -1), strict=True)]
        moved = motion(spins, _Turning.of(known).swings(known))
        flux_Wb = _flux_seen(blocks, known)
        _require_motion(moved, flux_Wb, known)
        pole_pairs = _pole_pairs(moved, known)
        direction = 1 if moved.per_rad > 0.0 else -1
        found = alignment(spins, pole_pairs, direction)
        if found.ripple_rad > _SLIPS_RAD:
            raise SetUpError(
                f"the rotor follows a current of {_SHARE:.0%} of the rated one only to "
                f"{math.degrees(found.ripple_rad):.0f} degrees electrical rms",
                "a load on the shaft, strong cogging, or an encoder that slips",
                "uncouple the load and tighten the encoder, then commission the motor alone",
            )
        measured = _measurements(found, pole_pairs, direction, known)
        seen = Measurement(
            "rotor_flux_seen", flux_Wb, "Wb", "voltage of the dragged rotor over its speed, about"
        )
        return {each.name: each for each in (*measured, seen)}

    def of_fault(self, code: int, known: Known) -> Finding | None:
        """Return what a speed beyond its limit means while a current drags the rotor slowly."""
        if code >> 8 != _TOO_FAST:
            return None
        return Finding(
            f"theta_m leaps: the drive sees a speed beyond its limit while a current drags the rotor at "
            f"{_Turning.of(known).omega_e_rad_s / known.motor.pole_pairs:.3g} rad/s",
            f"the encoder has not the {known.encoder_lines} lines that encoder_lines states, so that its "
            f"count wraps elsewhere, or it loses counts",
            "read the line count off the encoder, correct encoder_lines, and check cable and shield",
        )

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what does not fit the nameplate, and what is worn or loaded."""
        findings = []
        stated = known.held.get("encoder_direction", "forward") == "reverse"
        counts_down = found["encoder_direction"].value < 0.0
        if stated and not counts_down:
            findings.append(
                Finding(
                    "the encoder counts up while the current turns from phase a to b, and "
                    'encoder_direction is "reverse"',
                    "the tracks A and B, or two phases, have been exchanged since",
                    'state encoder_direction = "forward" in [drive.parameters] of the profile',
                    fails=False,
                )
            )
        if counts_down and not stated:
            findings.append(
                Finding(
                    "the encoder counts down while the current turns from phase a to b",
                    "the encoder is reversed (its tracks A and B are exchanged), or two phases are swapped",
                    "if the shaft turned the right way on `turning on`, exchange A and B, else two "
                    "phases; or "
                    'state encoder_direction = "reverse" in [drive.parameters] of the profile',
                    fails=False,
                )
            )
        once = abs(known.with_estimates(found).eccentricity_rad[0])
        if once > _ECCENTRIC_RAD:
            findings.append(
                Finding(
                    f"the encoder's angle is off by up to {math.degrees(once):.2g} degrees once in a "
                    f"revolution",
                    "its disc is eccentric to the shaft",
                    "centre the encoder's disc, or mount it again",
                    fails=False,
                )
            )
        if (lag := abs(found["friction_lag"].value)) > _LOADED_RAD:
            findings.append(
                Finding(
                    f"friction holds the rotor back by {math.degrees(lag):.0f} degrees electrical at "
                    f"{_SHARE:.0%} of the rated current",
                    "a load on the shaft, or a bearing or brake that rubs",
                    "uncouple the load and release the brake",
                    fails=False,
                )
            )
        return tuple(findings)


@dataclass(frozen=True)
class _Turning:
    """How the current turns: electrical speed, time until it is reached, duration, and angle at the end.

    Faster than the rotor swings about the current, whatever cogging, harmonics and dead time excite once and
    more often in an electrical revolution is beyond that resonance, and averages out.
    """

    omega_e_rad_s: float
    lead_s: float
    duration_s: float
    end_rad: float

    @classmethod
    def of(cls, known: Known) -> Self:
        """Return a revolution, or what of one the shaft may turn, with what comes before."""
        motor, p = known.motor, known.motor.pole_pairs
        swing = math.sqrt(_SHARE) * known.swing_rad_s
        most = 0.8 * p * known.travel_rad
        omega_e = min(_OF_SWING * swing, _OF_RATED * p * motor.omega_m_N_rad_s)
        if math.isfinite(most):
            omega_e = min(omega_e, swing * math.sqrt(0.3 * most * _ACCELERATION))
        lead_s = omega_e / (_ACCELERATION * swing**2)
        lead = 0.5 * omega_e * lead_s
        a_turn = 2.0 * math.pi * p
        turns = min(max(1, round(_SPUN_S * omega_e / a_turn)), _MOST_TURNS)
        turned = min(turns * a_turn * _REVOLUTIONS, most - 2.0 * lead)
        return cls(omega_e, lead_s, 2.0 * lead_s + turned / omega_e, 2.0 * lead + turned)

    def swings(self, known: Known) -> float:
        """Return how often the rotor swings about the current while that turns evenly."""
        even_s = self.duration_s - 2.0 * self.lead_s
        return even_s * math.sqrt(_SHARE) * known.swing_rad_s / (2.0 * math.pi)


def _spin(block: Block, known: Known, sense: int) -> Spin:
    """Return the part of a capture in which the current turns evenly."""
    even = _even_rows(block, known)
    i = vector_of(np.column_stack([block.column(name) for name in CURRENTS])[even] * known.gains)
    share = np.abs(i) / (_SHARE * known.I_N_A)
    return Spin(block.column("theta_m")[even], np.angle(i), share, sense)


def _even_rows(block: Block, known: Known) -> slice:
    """Return the rows between coming up to speed and coming to rest."""
    lead = math.ceil(_Turning.of(known).lead_s / (block.tick_s * block.stride))
    return slice(lead, len(block.data) - lead)


def _flux_seen(blocks: Sequence[Block], known: Known) -> float:
    """Return the rotor flux in Wb by what the voltage has beyond resistance and inductance."""
    seen = []
    omega_e = _Turning.of(known).omega_e_rad_s
    for block, sense in zip(blocks, (1, -1), strict=True):
        even = _even_rows(block, known)
        i = vector_of(np.column_stack([block.column(name) for name in CURRENTS])[even] * known.gains)
        u = (block.column("u_alpha") + 1j * block.column("u_beta"))[even]
        across = np.mean((u * np.conj(i / np.abs(i))).imag)
        L = 0.5 * (known.identified.L_d_H + known.identified.L_q_H)
        seen.append(across / (sense * omega_e) - L * float(np.mean(np.abs(i))))
    return float(np.mean(seen))


def _require_motion(moved: Motion, flux_Wb: float, known: Known) -> None:
    expected = 2.0 * math.pi * _REVOLUTIONS
    if moved.moved_rad > _HARDLY * min(expected, 0.8 * known.travel_rad):
        return
    if flux_Wb > _EMF_SEEN * known.motor.psi_r_Wb:
        raise SetUpError(
            f"the rotor turns, by the voltage that it induces, and theta_m changes by "
            f"{math.degrees(moved.moved_rad):.2g} degrees",
            "the encoder is not connected, its supply is missing, or its coupling to the shaft is loose",
            "check the encoder's cable, supply and coupling",
        )
    raise SetUpError(
        f"theta_m changes by {math.degrees(moved.moved_rad):.2g} degrees while a current of "
        f"{_SHARE:.0%} of the "
        f"rated one turns, and the motor induces no voltage",
        "the rotor is locked, by a brake, a load, or a tool that was left in",
        "release the brake and see that the shaft turns freely by hand",
    )


def _pole_pairs(moved: Motion, known: Known) -> int:
    """Return the pole pairs, a whole number.

    Raises:
        SetUpError: they are no whole number, or not those of the nameplate.
    """
    stated, lines = known.motor.pole_pairs, known.encoder_lines
    ratio = 1.0 / abs(moved.per_rad)
    nearest = max(1, round(ratio))
    eccentric = 0.0
    if moved.error_left:
        eccentric = 2.0 * _ECCENTRIC_RAD * abs(math.sin(0.5 * moved.moved_rad)) / moved.moved_rad
    unsure = max(_WHOLE_NUMBER * ratio, _SURE * moved.per_rad_standard * ratio**2 + eccentric * ratio)
    unsure = min(unsure, _NEAREST)
    if abs(moved.jump_rad) > _LEAP_RAD:
        raise SetUpError(
            f"theta_m leaps by {math.degrees(moved.jump_rad):.1f} degrees once in a revolution, and "
            f"the current "
            f"turns {ratio:.4g} times for one of theta_m, where {stated} pole pairs are stated",
            f"the encoder has not the {lines} lines that encoder_lines states: about "
            f"{lines * stated / ratio:.0f} by the pole pairs",
            "read the line count off the encoder, and correct encoder_lines",
        )
    if abs(ratio - nearest) > unsure:
        raise SetUpError(
            f"the current turns {ratio:.4g} times for one revolution of theta_m, a whole number of "
            f"pole pairs "
            f"is expected, {stated} by the nameplate",
            f"the encoder slips on its shaft or loses counts, or it has not {lines} lines (about "
            f"{lines * stated / ratio:.0f} by the pole pairs), or a gearbox is between it and the rotor",
            "tighten the encoder's coupling, check its cable and shield, and compare encoder_lines "
            "with its label",
        )
    if nearest != stated:
        raise SetUpError(
            f"the motor has {nearest} pole pairs, {stated} are stated",
            f"the pole pairs are wrong (poles, or magnets, taken for pairs), the encoder has "
            f"{lines * stated / nearest:.0f} lines and not {lines}, or it slips on its shaft or a gearbox is "
            f"between it and the rotor",
            "count the magnets: half of their number goes into motor.pole_pairs; check encoder_lines and the "
            "encoder's coupling",
        )
    return nearest


def _measurements(found: Alignment, pole_pairs: int, direction: int, known: Known) -> tuple[Measurement, ...]:
    p = pole_pairs
    basis = Basis(samples=found.dof)
    count_rad = 2.0 * math.pi / (4.0 * known.encoder_lines)
    lines = [
        Contribution("deviations over the revolutions", "A", found.offset_standard_rad, found.dof),
        Contribution("count of the encoder", "B", count_rad / math.sqrt(12.0)),
        Contribution("what the equation leaves out", "B", _LEFT_OUT_RAD / p / math.sqrt(3.0)),
    ]
    source = "deviations from the current's angle"
    offset = Measurement(
        "encoder_offset",
        found.offset_rad,
        "rad",
        "mechanical angle of the encoder's zero against the rotor flux on phase a, mean of both ways "
        "of turning",
        basis,
        combined(lines, source),
    )
    exact = (
        ("pole_pairs", float(p), "revolutions of the current for one of the encoder"),
        ("encoder_direction", float(direction), "1 where it counts up while the current turns from a to b"),
    )
    whole = [Measurement(name, value, "", definition, basis) for name, value, definition in exact]
    return (*whole, offset, *_of_errors(found, basis), _lag(found, basis))


def _of_errors(found: Alignment, basis: Basis) -> tuple[Measurement, ...]:
    measured = []
    for n in (1, 2):
        for part in ("cos", "sin"):
            name = f"eccentricity_{n}_{part}"
            definition = f"what the encoder is ahead of the shaft by, in {part} {n} theta_m"
            if found.errors_rad is None:
                reason = "less than a revolution was turned"
                measured.append(Measurement.undefined(name, "rad", definition, reason, basis))
                continue
            assert found.apart_rad is not None
            apart_rad = found.apart_rad[n - 1]
            lines = [
                Contribution("deviations over the revolutions", "A", found.error_standard_rad, found.dof),
                Contribution(
                    "swings of the rotor, which differ both ways",
                    "A",
                    apart_rad / math.sqrt(8.0),  # of the mean of two, in one of two parts
                    2.0,
                ),
            ]
            alone = Uncertainty(found.error_standard_rad, lines[0].name, found.dof)
            U_rad = math.hypot(alone.expanded, _ALIKE * apart_rad)
            z = found.errors_rad[n - 1]
            value = z.real if part == "cos" else z.imag
            source = "deviations over the revolutions and between both ways"
            u = combined(lines, source, half_width=U_rad)
            measured.append(Measurement(name, value, "rad", definition, basis, u))
    return tuple(measured)


def _lag(found: Alignment, basis: Basis) -> Measurement:
    lines = [
        Contribution("deviations over the revolutions", "A", found.lag_standard_rad, found.dof),
        Contribution("what the equation leaves out", "B", _LEFT_OUT_RAD / math.sqrt(3.0)),
    ]
    u = combined(lines, "deviations from the current's angle")
    definition = "electrical angle by which friction holds the rotor behind the current"
    return Measurement("friction_lag", found.lag_rad, "rad", definition, basis, u)
