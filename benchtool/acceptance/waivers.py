"""Waivers: who consents to which failing test, why, and until when."""

from __future__ import annotations

import fnmatch
from collections.abc import Collection, Sequence
from datetime import date
from pathlib import Path

from pydantic import ValidationError

from benchtool.document import Array, Section, load_document
from benchtool.errors import UsageError
from benchtool.file_kinds import FileKind
from benchtool.results import Waiver


class _Waivers(Section):
    """A file of waivers: `[[waiver]]` with `test` or `requirement`, `reason`, `by` and perhaps `until`."""

    waiver: Array[Waiver] = ()


def load_waivers(path: Path) -> tuple[Waiver, ...]:
    """Return the waivers in a TOML file.

    Raises:
        UsageError: it cannot be read, a key is wrong, or a waiver has no test, no reason or no name of who
            consents.
    """
    found = load_document(path, _Waivers, UsageError, kind=FileKind.WAIVERS).waiver
    for number, each in enumerate(found, start=1):
        place = f"{path}: waiver {number}"
        if bool(each.test) == bool(each.requirement):
            raise UsageError(f"{place}: one of test and requirement is expected: state which one is waived")
        if not each.reason.strip() or not each.by.strip():
            raise UsageError(
                f"{place}: reason and by are empty, a sentence and a name are expected: state both"
            )
        if each.until:
            _day(each.until, place)
    return found


def waiver_of(
    waivers: Sequence[Waiver], test: str, requirements: Collection[str], today: date
) -> Waiver | None:
    """Return the waiver that holds for a test on a day; its pattern may have `*` in it."""
    for each in waivers:
        if each.until and _day(each.until, "a waiver") < today:
            continue
        if each.test and fnmatch.fnmatchcase(test, each.test):
            return each
        if each.requirement and each.requirement in requirements:
            return each
    return None


def of_marker(reason: str, by: str, until: str = "") -> Waiver:
    """Return the waiver that a test states of itself.

    Raises:
        UsageError: reason or name are empty, or `until` is no date.
    """
    try:
        waiver = Waiver(reason=reason, by=by, until=until, test="*")
    except ValidationError as failed:
        raise UsageError(f"marker waived: {failed.errors()[0]['msg']}; text is expected") from None
    if not reason.strip() or not by.strip():
        raise UsageError(
            "marker waived: reason and by are empty, a sentence and a name are expected: state both"
        )
    if until:
        _day(until, "marker waived")
    return waiver


def _day(text: str, place: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise UsageError(
            f"{place}: until is {text!r}, a date such as 2027-03-01 is expected: correct it"
        ) from None
