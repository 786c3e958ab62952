"""The largest line of a record as numbers, and the ten largest as a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.lines.steadiness import Line
from benchtool.analysis.lines.swinging_lines import is_sideband
from benchtool.analysis.measurement import Basis, LineColumn, Measurement, Table
from benchtool.analysis.numbers import raw
from benchtool.analysis.sensitivity import Sensitivities
from benchtool.analysis.statistics.repeatability import wander_of_line
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined

LISTED = 10
"""Lines of a table."""

STANDS_OUT = 5.0
"""Times the rms amplitude of the noise around a line: by chance once in 1e11 bins."""

_APART = 2.0  # standard uncertainties of a difference
_SOURCE = "noise around the line and resolution, and what else its shape allows"


@dataclass(frozen=True)
class SpectralLines:
    """Result of `spectral_lines`: NAME_line_frequency, NAME_line_amplitude, table NAME_lines."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]


@dataclass(frozen=True)
class LinesOf:
    """Samples, shape (n,), of a `channel`, at a rate of the standard uncertainty `rate_relative`, relative to
    it; the results are named after `name`."""

    samples: NDArray[np.float64]
    rate_Hz: float
    name: str
    channel: str
    unit: str
    basis: Basis
    rate_relative: float

    @property
    def width_Hz(self) -> float:
        """Distance between two bins."""
        return self.rate_Hz / len(self.samples)

    def with_lines(self, rows: Sequence[Line], slower: str) -> SpectralLines:
        """Return the first of the `rows` as numbers, and the table of all. What is `slower`, or drifts, may
        be larger than the first: a reason, or empty."""
        numbers = self._frequency(rows, slower), self._amplitude(rows, slower)
        return SpectralLines(numbers, (self._table(rows[:LISTED]),))

    def without_lines(self, reason: str, below: float | None = None) -> SpectralLines:
        """Return both numbers undefined. An amplitude is `below` the least that would stand out."""
        frequency = Measurement.undefined(
            f"{self.name}_line_frequency", "Hz", self._of_frequency, reason, self.basis
        )
        amplitude = Measurement.undefined(
            f"{self.name}_line_amplitude", self.unit, self._of_amplitude, reason, self.basis
        )
        return SpectralLines((frequency, replace(amplitude, below=below)), (self._table(()),))

    @property
    def _lines(self) -> str:
        width = f"{raw(self.width_Hz, 4)} Hz a bin"
        return f"{self.channel}, of the lines above {STANDS_OUT:g} times the noise around them, {width}"

    @property
    def _of_frequency(self) -> str:
        return f"mean frequency of the largest sinusoid of {self._lines}"

    @property
    def _of_amplitude(self) -> str:
        return f"mean peak amplitude of the largest sinusoid of {self._lines}, without its sidebands"

    def _frequency(self, rows: Sequence[Line], slower: str) -> Measurement:
        largest, place_Hz = rows[0], rows[0].place * self.width_Hz
        text, name = self._of_frequency, f"{self.name}_line_frequency"
        if largest.unsure:
            text += ", between its sidebands, whatever part of a swing the record holds"
        reason = slower or largest.reason
        if not reason and len(rows) > 1:
            reason = _not_apart(largest, rows[1], self.unit)
        if reason:
            return Measurement.undefined(name, "Hz", text, reason, self.basis)
        uncertain: Uncertainty | None = Uncertainty(self.width_Hz * largest.of_place, _SOURCE)
        if self.rate_relative > 0.0:
            own = Contribution(_SOURCE, "A", self.width_Hz * largest.of_place)
            of_rate = Contribution("sample rate", "B", self.rate_relative * place_Hz)
            uncertain = combined([own, of_rate], f"{_SOURCE}, and the rate by the time stamps")
        return Measurement(
            name,
            place_Hz,
            "Hz",
            text,
            replace(self.basis, line_Hz=place_Hz, frequency_Hz=place_Hz),
            uncertain,
            sensitivities=Sensitivities.unmoved(self.channel).chosen,
            repeatability=wander_of_line(self.samples - np.mean(self.samples), self.rate_Hz, place_Hz),
        )

    def _amplitude(self, rows: Sequence[Line], slower: str) -> Measurement:
        largest, place_Hz = rows[0], rows[0].place * self.width_Hz
        text, name = self._of_amplitude, f"{self.name}_line_amplitude"
        if why := slower or largest.reason or largest.of_mean:
            return Measurement.undefined(name, self.unit, text, why, self.basis)
        unsure = largest.unsure or next((each.unsure for each in rows if is_sideband(largest, each)), "")
        return Measurement(
            name,
            largest.amplitude,
            self.unit,
            text,
            replace(self.basis, line_Hz=place_Hz, frequency_Hz=place_Hz),
            None if unsure else Uncertainty(largest.of_amplitude, _SOURCE),
            uncertainty_reason=unsure,
            sensitivities=Sensitivities.of_line(self.channel, largest.amplitude).chosen,
        )

    def _table(self, rows: Sequence[Line]) -> Table:
        return Table(
            f"{self.name}_lines",
            f"the largest sinusoids of {self._lines}, means over the record, with standard uncertainties "
            f"from the noise around each; none where its amplitude or frequency changes so that the line is "
            f"wider",
            (
                *(("frequency_Hz", "Hz"), ("amplitude", self.unit)),
                *(("frequency_uncertainty_Hz", "Hz"), ("amplitude_uncertainty", self.unit)),
            ),
            tuple(
                (
                    each.place * self.width_Hz,
                    each.amplitude,
                    self.width_Hz * math.hypot(each.of_place, self.rate_relative * each.place),
                    each.of_amplitude,
                )
                for each in rows
            ),
            self.basis,
            lines=(
                LineColumn("amplitude", "amplitude_uncertainty", self.channel, "frequency_Hz"),
                LineColumn(
                    "frequency_Hz",
                    "frequency_uncertainty_Hz",
                    self.channel,
                    "frequency_Hz",
                    is_amplitude=False,
                ),
            ),
        )


def _not_apart(largest: Line, second: Line, unit: str) -> str:
    """Return why the largest line is ambiguous; empty if it is not."""
    both = math.hypot(largest.of_amplitude, second.amplitude if second.reason else second.of_amplitude)
    if largest.amplitude - second.amplitude > _APART * both:
        return ""
    return (
        f"two lines, of {raw(largest.amplitude, 4)} and {raw(second.amplitude, 4)} {unit}, are equally large "
        f"within their uncertainty: the table has both"
    )
