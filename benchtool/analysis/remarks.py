"""Remarks on the signals that numbers are of."""

from __future__ import annotations

import math
from collections.abc import Iterable

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.phase.mean_frequency import angle_remarks
from benchtool.analysis.spectra.flat_crests import flat_crest_remark


def signal_remarks(measurements: Iterable[Measurement]) -> tuple[str, ...]:
    """Return that a current and a rotor angle do not turn together, and that a current has flat crests, each
    if it is so."""
    told = list(measurements)
    return tuple(filter(None, (*angle_remarks(told), flat_crest_remark(told))))


def pulse_note(measurements: Iterable[Measurement]) -> str:
    """Return that a settling time contains how long a pulse was held; empty where there is none.

    The plateau of a pulse ends before the record does.
    """
    found = {each.name: each for each in measurements}
    settling, plateau, tracking = (
        found.get(name) for name in ("settling_time", "plateau_mean", "tracking_error_mean")
    )
    if settling is None or plateau is None or tracking is None or not math.isfinite(settling.value):
        return ""
    held_s, recorded_s = plateau.basis.span_s, tracking.basis.span_s
    if held_s is None or recorded_s is None or not held_s < recorded_s:
        return ""
    after_s = max(0.0, settling.value - held_s)
    return (
        f"settling_time counts from the step on: the reference was held for {raw(held_s, 4)} s and fell, and "
        f"the signal settled {raw(after_s, 3)} s later"
    )
