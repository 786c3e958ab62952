"""How the sensors of three phase currents are wired: one that reads backwards, or two that are swapped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import raw
from benchtool.analysis.orders import unwrapped_angle
from benchtool.errors import AnalysisError
from benchtool.tables.columns import PHASES
from benchtool.tables.record import Record

Floats = NDArray[np.float64]

_LEFT = 0.25  # of the sum of the phases, with one of them the other way
_ALIKE = 0.5  # of the largest current: the least of three that a machine in balance has
_SAME_TURN, _MOST_RAD = 0.2, 2.0  # of the turn from row to row; that a current is seen to turn by


def miswired(record: Record) -> tuple[str, str]:
    """Return the kind of a column and why its phase is taken to be read backwards or for another one; both
    empty where they are not."""
    if not record.channels.keys() >= set(PHASES):
        return "", ""
    currents = np.stack([record.column(each) - np.mean(record.column(each)) for each in PHASES])
    rms = np.sqrt(np.mean(currents**2, axis=1))
    if not np.all(np.isfinite(rms)) or not np.min(rms) > _ALIKE * np.max(rms):
        return "", ""
    if found := _backwards(record, currents):
        return found
    text = _against_the_angle(record, currents)
    return ("current", text) if text else ("", "")


def _backwards(record: Record, currents: Floats) -> tuple[str, str] | None:
    """Return the phase without which, read the other way, currents, shape (3, n), do not add up to zero."""
    whole = np.sum(currents, axis=0)
    turned = np.sqrt(np.mean((whole - 2.0 * currents) ** 2, axis=1))
    phase, total = int(np.argmin(turned)), float(np.sqrt(np.mean(whole**2)))
    if not turned[phase] < _LEFT * total:
        return None
    what = PHASES[phase]
    name, unit = record.channels[what].name, record.channels[what].unit
    return what, (
        f"the phases add up to {raw(total, 3)} {unit} rms, and with '{name}' the other way to "
        f"{raw(float(turned[phase]), 3)} {unit}: its sensor reads backwards, turn it or state a gain of -1"
    )


def _against_the_angle(record: Record, currents: Floats) -> str:
    """Return that currents, shape (3, n), turn against the angle; empty where they do not, or none tells."""
    pole_pairs = record.question.pole_pairs
    if pole_pairs is None or "angle" not in record.channels or record.angle_refusal:
        return ""
    try:
        angle_rad = unwrapped_angle(record.column("angle"), record.channels["angle"].name)
    except AnalysisError:  # in another unit, or dead
        return ""
    vector = np.exp(2j * np.pi / 3.0 * np.arange(3)) @ currents
    turn = float(np.angle(np.sum(vector[1:] * np.conj(vector[:-1]))))
    expected = pole_pairs * float(angle_rad[-1] - angle_rad[0]) / (len(angle_rad) - 1)
    if not (abs(turn + expected) < _SAME_TURN * abs(expected) and abs(expected) < _MOST_RAD):
        return ""
    names = ", ".join(f"'{record.channels[each].name}'" for each in PHASES)
    return (
        f"{names} follow each other against the angle '{record.channels['angle'].name}': two phases are "
        f"swapped, or the angle counts the other way; the larger sequence is called positive all the same"
    )
