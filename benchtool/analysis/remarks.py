"""Remarks on the signals that numbers are of, and on how the numbers are to be read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.numbers import number, raw, with_unit
from benchtool.analysis.phase.mean_frequency import angle_remarks
from benchtool.analysis.spectra.flat_crests import flat_crest_remark

_SHOWS: Final = 1.1  # times U, which repeatability is told from


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


def repeatability_notes(measurements: Iterable[Measurement]) -> Iterator[str]:
    """Yield by how much numbers of another record of the same state differ from these besides their U, where
    that shows beside it; of several numbers of one name that differ most."""
    largest: dict[str, Measurement] = {}
    for each in measurements:
        own, of_state, known = each.uncertainty, each.uncertainty_of_state, largest.get(each.name)
        if each.repeatability is None or own is None or of_state is None:
            continue
        if of_state.expanded > _SHOWS * own.expanded and (
            known is None
            or known.repeatability is None
            or known.repeatability.standard < each.repeatability.standard
        ):
            largest[each.name] = each
    for name, each in largest.items():
        if each.repeatability is not None:
            u = with_unit(number(each.repeatability.standard, 2), each.unit)
            yield (
                f"{name} differs between records of this state by u = {u} besides its U: "
                f"{each.repeatability.name}"
            )


def correction_notes(measurements: Iterable[Measurement]) -> Iterator[str]:
    """Yield for each bandwidth the numbers that are corrected by more than their U, the first in full; of
    several of one name it is the one that is corrected most."""
    largest: dict[str, dict[str, tuple[float, Measurement]]] = {}
    for each in measurements:
        own, correction = each.uncertainty, each.correction
        if own is None or correction is None or not abs(correction.added) > own.expanded:
            continue
        of_sensors = largest.setdefault(correction.of, {})
        if each.name not in of_sensors or abs(correction.added) > abs(of_sensors[each.name][0]):
            of_sensors[each.name] = correction.added, each
    for of, found in largest.items():
        added, first = next(iter(found.values()))
        by, read = (with_unit(text, first.unit) for text in (number(added, 2), number(first.as_read, 3)))
        more = f" and {len(found) - 1} more" if len(found) > 1 else ""
        yield f"corrected by more than U: {first.name} by {by} from {read} as read{more} ({of})"
