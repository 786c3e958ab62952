"""Remarks on the signals that numbers are of."""

from __future__ import annotations

from collections.abc import Iterable

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.phase.mean_frequency import angle_remarks
from benchtool.analysis.spectra.flat_crests import flat_crest_remark


def signal_remarks(measurements: Iterable[Measurement]) -> tuple[str, ...]:
    """Return that a current and a rotor angle do not turn together, and that a current has flat crests, each
    if it is so."""
    told = list(measurements)
    return tuple(filter(None, (*angle_remarks(told), flat_crest_remark(told))))
