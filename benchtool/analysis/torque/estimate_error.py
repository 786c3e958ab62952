"""Error of the drive's estimate of torque: its mean less that of a transducer, over the same time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.period_marks import marks_of_rotor
from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.analysis.sensitivity import OF_MEAN_STEP, Sensitivities, Sensitivity
from benchtool.analysis.statistics.scatter import TOO_SLOW
from benchtool.analysis.torque.means_of_periods import MeanOverPeriods, Periods, mean_over_periods
from benchtool.analysis.uncertainty import Contribution, combined_by_names
from benchtool.block import Block

_SCATTER: Final = "scatter of the difference over the periods"

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class TorqueOfBoth:
    """Torque by the drive's estimate and by a transducer over the same time, each with its mean and phase.

    A load that wanders is in both and not in their difference, which has means of periods of its own.
    """

    block: Block
    transducer: Block
    estimated: Measurement
    true: Measurement
    track: PhaseTrack | None
    track_of_transducer: PhaseTrack | None
    per_revolution: int

    def error(self, what: str) -> Measurement:
        """Return torque_error, the estimate less the transducer, which is `what` in words."""
        difference, estimated, true = self._difference(), self.estimated, self.true
        value, uncertain = estimated.value - true.value, None
        why = estimated.uncertainty_reason or true.uncertainty_reason
        if difference is not None and math.isfinite(value):
            value, why = difference.mean, TOO_SLOW
            uncertain = combined_by_names([difference.error.line(_SCATTER), *self._of_steps()])
        samples, rate_Hz = len(self.transducer.data), self.transducer.sample_rate_Hz
        basis = replace(
            estimated.basis,
            reference=f"torque_transducer, {samples} samples at {raw(rate_Hz)} Hz",
            alignment_s=self.transducer.alignment_s or None,
        )
        return Measurement(
            "torque_error",
            value,
            "Nm",
            f"mean of the drive's estimate torque minus {what}",
            basis,
            uncertain,
            uncertainty_reason=why if uncertain is None else "",
            sensitivities=Sensitivities(
                (
                    Sensitivity("torque", estimated.value, 1.0, OF_MEAN_STEP),
                    Sensitivity("torque_transducer", -true.value, -1.0, OF_MEAN_STEP),
                )
            ),
        )

    def _of_steps(self) -> Iterator[Contribution]:
        """Yield what steps leave uncertain of both means: as told of them, or all that they may where a mean
        wanders too slowly to have an uncertainty."""
        of_estimate = ("estimate", self.estimated.uncertainty, self.block.column("torque"))
        true = self.transducer.column("torque_transducer")
        for name, uncertain, samples in (of_estimate, ("transducer", self.true.uncertainty, true)):
            if uncertain is None:
                step = counting_step(np.ascontiguousarray(samples))
                steps = [Contribution(f"resolution {step:.3g} Nm", "B", step / math.sqrt(12.0))]
            else:
                steps = [each for each in uncertain.budget if each.evaluation == "B"]
            yield from (replace(each, name=f"{each.name} of the {name}") for each in steps if each.standard)

    def _difference(self) -> MeanOverPeriods | None:
        """Return the mean of the difference over whole periods; None without a phase, or of too few."""
        if self.track is None or self.track_of_transducer is None:
            return None
        samples, track = self._at_the_finer_rows(self.track, self.track_of_transducer)
        periods = Periods.of(marks_of_rotor(track), self.per_revolution)
        if not periods.tell_scatter:
            return None
        return mean_over_periods(samples, periods, may_fall=True, by_revolutions=True)

    def _at_the_finer_rows(
        self, track: PhaseTrack, track_of_transducer: PhaseTrack
    ) -> tuple[Floats, PhaseTrack]:
        """Return the difference, shape (n,), and the phase at its rows, which are those of the higher rate: a
        straight line between the rows of the other signal leaves its means as they are."""
        of_block, of_transducer = (each.ticks() * each.tick_s for each in (self.block, self.transducer))
        torque, true = self.block.column("torque"), self.transducer.column("torque_transducer")
        if self.block.sample_rate_Hz >= self.transducer.sample_rate_Hz:
            return torque - np.interp(of_block, of_transducer, true), track
        return np.interp(of_transducer, of_block, torque) - true, track_of_transducer
