"""Offsets and noise of the current sensors, with the power stage off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from benchtool.analysis import Basis, Contribution, Measurement, Uncertainty
from benchtool.block import Block
from benchtool.commission.estimators.zero_current import ZeroCurrent, zero_current
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest

CURRENTS = ("i_a", "i_b", "i_c")
_ROWS = 2000
_LARGEST_OFFSET = 0.2  # of the rated current, peak


class Offsets:
    """Read the sensors while no current flows.

    The drive's own corrections are at nothing meanwhile, so that the readings are those of the sensors.
    """

    name = "offsets"
    needs: tuple[str, ...] = ("preflight",)
    sets: tuple[str, ...] = ("current_offset_a", "current_offset_b", "current_offset_c")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a capture with the power stage off."""
        nothing = {f"current_{what}_{phase}": value for phase in "abc" for what, value in _NEUTRAL}
        return (Excitation("no current", None, CaptureRequest(CURRENTS, _ROWS), parameters=nothing),)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `current_offset_*` and `current_noise_*`.

        Raises:
            AnalysisError: too few readings.
        """
        (block,) = blocks
        found: dict[str, Measurement] = {}
        for phase, channel in zip("abc", CURRENTS, strict=True):
            zero = zero_current(block.column(channel))
            for each in _measurements(phase, zero, len(block.data), known.control_period_s):
                found[each.name] = each
        return found

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return sensors that are dead, or read a current that there should not be."""
        findings = []
        for phase in "abc":
            offset, noise = found[f"current_offset_{phase}"].value, found[f"current_noise_{phase}"].value
            if abs(offset) > _LARGEST_OFFSET * known.I_N_A:
                findings.append(
                    Finding(
                        f"the sensor of output {phase} reads {offset:.4g} A with the power stage off, within "
                        f"{_LARGEST_OFFSET:.0%} of the rated {known.I_N_A:.4g} A peak is expected",
                        "the shaft turns, the sensor or its supply is broken, or the rated current is wrong",
                        "hold the shaft still, check the sensor and motor.I_N_A_rms of the profile",
                    )
                )
            if noise == 0.0 and math.isfinite(offset) and abs(offset) > 0.0:
                findings.append(
                    Finding(
                        f"the sensor of output {phase} reads {offset:.4g} A without any noise",
                        "its converter stands at one code: the channel may be stuck",
                        "check the sensor's cable and the converter's channel",
                        fails=False,
                    )
                )
        return tuple(findings)


_NEUTRAL = (("offset", 0.0), ("gain", 1.0))


def _measurements(phase: str, zero: ZeroCurrent, rows: int, T_s: float) -> tuple[Measurement, Measurement]:
    basis = Basis(samples=rows, sample_rate_Hz=1.0 / T_s, duration_s=rows * T_s)
    offset = Measurement(
        f"current_offset_{phase}",
        zero.offset_A,
        "A",
        f"mean of i_{phase} with the power stage off, uncorrected",
        basis,
        Uncertainty(
            zero.standard_A,
            "scatter of the samples and the converter's step",
            zero.dof,
            (Contribution("mean of the samples", "A", zero.standard_A, zero.dof),),
        ),
    )
    u_noise = zero.noise_A_rms / math.sqrt(2.0 * zero.dof)
    noise = Measurement(
        f"current_noise_{phase}",
        zero.noise_A_rms,
        "A",
        f"standard deviation of i_{phase} with the power stage off",
        basis,
        Uncertainty(u_noise, "scatter of the samples", zero.dof),
    )
    return offset, noise
