"""Stator resistance, the voltage of dead time and devices, and how the current sensors' gains differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Basis, Contribution, Measurement, combined, sure_of
from benchtool.block import Block
from benchtool.commission.budget import of_fit
from benchtool.commission.estimators.resistance import resistance
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import SERIES_AS_STATED, Known
from benchtool.commission.nameplate import IN_SERIES_OHM, WINDING_R
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus

_LEVELS = 8
_LEVEL_S = 0.27
_ALIGNING = 2  # levels in which the rotor comes into line, and which are not used
_STANDS = 0.02  # of the largest current: how little a current that stands may change
_SETTLED = 0.6  # of a level, after which its mean begins
_ROW_S = 2e-3
_ASIDE_DEG = (-12.0, -6.6, -1.9, 4.3, 8.5, 10.7)  # from the phases
_SHARES = (1.0, 0.935, 0.97, 0.91, 0.985, 0.95)  # of the rated current
_FACTOR = 1.5  # from the nameplate on, a resistance is told of
_OF_LINE_TO_LINE = 0.5
_NEAR = 0.15
_UNEQUAL, _SURE = 0.12, 6.0  # a phase's resistance off the mean of the three; `sure_of` so many of that


class StandingCurrents:
    """Have standing currents of several sizes flow along each phase in both directions.

    The current loop is about as slow as the swing of the rotor into line, which the stator then damps. The
    rotor turns by 60 degrees electrical from one direction to the next.
    """

    name = "resistance"
    needs: tuple[str, ...] = ("offsets", "connections")
    sets: tuple[str, ...] = ("R_s", "dead_time_voltage", "current_gain_a", "current_gain_b", "current_gain_c")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a staircase of currents up to the rated one in each of six directions."""
        stride = max(1, round(_ROW_S / known.control_period_s))
        rows = math.floor(_LEVELS * _LEVEL_S / (stride * known.control_period_s)) - 1
        request = CaptureRequest((*CURRENTS, "u_alpha", "u_beta"), rows=rows, stride=stride)
        squares = sum((level / _LEVELS) ** 2 for level in range(1, _LEVELS + 1))
        return tuple(
            Excitation(
                f"currents at {math.degrees(angle_rad):.0f} deg",
                Stimulus(
                    quantity="current",
                    shape="staircase",
                    steps=_LEVELS,
                    amplitude_A=share * known.I_N_A,
                    duration_s=_LEVELS * _LEVEL_S,
                    angle_rad=angle_rad,
                ),
                request,
                (share * known.I_N_A) ** 2 * _LEVEL_S * squares,
                {
                    "omega_current": known.damping_bandwidth_rad_s,
                    "dead_time_compensation": 0.0,
                    **known.offsets,
                },
            )
            for angle_rad, share in _directions()
        )

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `R_s`, `dead_time_voltage` and `current_gain_*`.

        Raises:
            AnalysisError: the captures do not define them.
        """
        levels = np.array([mean for block in blocks for mean in _levels(block)]).reshape(-1, 5)
        found = resistance(levels[:, 3] + 1j * levels[:, 4], levels[:, :3])
        known = known.with_drop(found.drop_V)
        basis = Basis(samples=found.levels, duration_s=len(blocks) * _LEVELS * _LEVEL_S)
        scatter = f"scatter of {found.levels} levels about the fit"
        estimates = [
            Measurement(
                "R_s",
                found.R_s_ohm,
                "ohm",
                "slope of u_s over i_s at standing currents, per phase, with what the devices add",
                basis,
                of_fit(found.R_s_ohm, found.R_s_standard_ohm, found.dof, scatter, known),
            ),
            Measurement(
                "dead_time_voltage",
                found.drop_V,
                "V",
                "voltage that dead time and devices take of a phase, against its current",
                basis,
                of_fit(found.drop_V, found.drop_standard_V, found.dof, scatter, known),
            ),
        ]
        estimates.append(of_winding(estimates[0], known))
        gains = found.gains
        for phase, gain, standard in zip("abc", gains.corrections, gains.standard, strict=True):
            estimates.append(
                Measurement(
                    f"current_gain_{phase}",
                    float(gain),
                    "",
                    "factor that makes the currents of the phases add up to zero; the mean of the three is 1",
                    basis,
                    of_fit(0.0, float(standard), gains.dof, scatter, known),
                )
            )
        both = (found.of_phases_ohm, found.of_phases_standard_ohm)
        for phase, R_ohm, standard in zip("abc", *both, strict=True):
            estimates.append(
                Measurement(
                    f"R_{phase}",
                    float(R_ohm),
                    "ohm",
                    f"resistance of phase {phase} where the three may differ, likewise",
                    basis,
                    of_fit(float(R_ohm), float(standard), found.dof, scatter, known),
                )
            )
        return {each.name: each for each in estimates}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what the resistance says of nameplate and connections."""
        ratio = found["R_s"].value / known.motor.R_s_ohm if known.motor.R_s_ohm > 0.0 else math.nan
        if ratio <= 0.0:
            return (
                Finding(
                    f"the resistance is {found['R_s'].value:.4g} ohm, more than 0 is expected",
                    "the currents do not follow the voltages: phases of sensors and legs may not match",
                    "check the motor's cables and the order of the current sensors",
                ),
            )
        if apart := _apart(found):
            return (apart,)
        stated = known.motor.R_s_ohm
        seen = f"R_s is {found['R_s'].value:.4g} ohm, {ratio:.3g} times the nameplate's"
        if _looks_line_to_line(found["R_s"].value, stated, known.series_ohm):
            return (
                Finding(
                    f"{seen}: R looks line to line",
                    "motor.R_s_ohm is stated between two terminals",
                    "state the resistance of one phase, half of that between two terminals",
                    fails=False,
                ),
            )
        if not stated / _FACTOR < found["R_s"].value < _FACTOR * stated + IN_SERIES_OHM:
            return (
                Finding(
                    f"{seen}, within a factor of {_FACTOR:g} is expected",
                    "another motor, a long cable, a hot winding or a wrong nameplate",
                    "check motor.R_s_ohm of the profile, connections and cable",
                    fails=False,
                ),
            )
        return ()


def of_winding(R_s: Measurement, known: Known) -> Measurement:
    """Return the resistance of the winding alone: what was measured, less what is stated to be in series."""
    definition = "R_s less what is stated to be in series with the winding, drive.on_resistance_ohm"
    if not known.series_ohm or R_s.uncertainty is None:
        reason = "no drive.on_resistance_ohm is stated beside an R_s_ohm of the winding alone"
        return Measurement.undefined(WINDING_R, "ohm", definition, reason, R_s.basis)
    least, most = (share * known.series_ohm for share in SERIES_AS_STATED)
    lines = [
        R_s.uncertainty.line("R_s"),
        Contribution("what is stated to be in series", "B", (most - least) / math.sqrt(12.0)),
    ]
    u = combined(lines, "what is stated to be in series, R_s")
    return Measurement(WINDING_R, R_s.value - known.series_ohm, "ohm", definition, R_s.basis, u)


def _looks_line_to_line(R_s_ohm: float, stated_ohm: float, series_ohm: float | None) -> bool:
    """Return whether half of what the nameplate states was found, beside what is in series: as much as is
    stated of that, or some where nothing is."""
    half = _OF_LINE_TO_LINE * stated_ohm
    if abs((R_s_ohm - (series_ohm or 0.0)) / half - 1.0) < _NEAR:
        return True
    if series_ohm is not None:
        return False
    return half < R_s_ohm < min(half + IN_SERIES_OHM, stated_ohm / _FACTOR)


def _apart(found: Mapping[str, Measurement]) -> Finding | None:
    """Return that a phase has another resistance than the others, where it has."""
    each = {phase: found[f"R_{phase}"] for phase in "abc"}
    mean = sum(one.value for one in each.values()) / 3.0
    phase, odd = max(each.items(), key=lambda item: abs(item[1].value - mean))
    if abs(odd.value - mean) < max(_UNEQUAL * abs(mean), sure_of(odd.uncertainty, _SURE)):
        return None
    others = (3.0 * mean - odd.value) / 2.0
    what = (
        f"phase {phase} has {odd.value:.4g} ohm, the mean of the other two is {others:.4g} ohm; they "
        f"should be equal"
    )
    if odd.value < others:
        return Finding(
            what,
            f"a shorted phase: turns of phase {phase} are shorted, or its end touches the star point",
            "measure the winding between each two terminals and against earth; do not run this motor",
        )
    return Finding(
        what,
        f"phase {phase} has a poor contact, or another cable than the others",
        f"tighten the terminals of phase {phase}, check its cable and plug",
    )


def _directions() -> tuple[tuple[float, float], ...]:
    """Return angle and share of the rated current of six staircases, in the order in which the rotor follows.

    No two are alike, nor mirror images: the steps of the duties then spoil each level in another way, and
    their effect shows in the scatter about the fit.
    """
    return tuple(
        (k * math.pi / 3.0 + math.radians(aside_deg), share)
        for k, (aside_deg, share) in enumerate(zip(_ASIDE_DEG, _SHARES, strict=True))
    )


def _levels(block: Block) -> list[NDArray[np.float64]]:
    """Return the means of all channels over the settled part of each level that is used.

    A level whose current still changes, as while the integral part climbs to what dead time takes, is not.
    """
    rows = _LEVEL_S / (block.stride * block.tick_s)
    largest = np.max(np.abs(block.data[:, :3]))
    found = []
    for level in range(_ALIGNING, _LEVELS):
        part = block.data[math.ceil(rows * (level + _SETTLED)) : math.floor(rows * (level + 1)) - 1]
        half = len(part) // 2
        change = np.abs(part[half:, :3].mean(axis=0) - part[:half, :3].mean(axis=0))
        if np.max(change) < _STANDS * largest:
            found.append(part.mean(axis=0))
    return found
