"""The glossary: names and words that it rules out appear in no name, docstring, comment or message."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8")
FOLDERS = ("benchtool", "firmware_protocol", "benchmarks", "tests")
EXEMPT = {"former_names.py", "test_former_names.py", "test_glossary.py"}
"""Modules that hold former names on purpose."""

_BETWEEN = r"[\s#_]+"  # words of a phrase, over the end of a line or in a snake_case name
_DEFINED = re.compile(r"^\s*(?:async )?(?:class|def) (\w+)", re.MULTILINE)


def _ruled_out() -> frozenset[str]:
    """Names in the last column of the tables."""
    rows = (line.split("|") for line in PAGE.splitlines() if line.startswith("|"))
    return frozenset(name for row in rows for name in re.findall(r"`(\w+)`", row[-2]))


@cache
def _pattern(phrase: str) -> re.Pattern[str]:
    """A phrase as words of a text, or as parts of a name."""
    return re.compile(rf"(?<![^\W_]){_BETWEEN.join(phrase.split())}(?![^\W_])")


@cache
def _phrases() -> tuple[str, ...]:
    """Words and phrases at the end of the page."""
    return tuple(re.findall(r"`([a-z ]+)`", PAGE[PAGE.index("Words and phrases") :]))


@cache
def _sources() -> dict[str, str]:
    return {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
        for folder in FOLDERS
        for path in sorted((ROOT / folder).rglob("*.py"))
        if path.name not in EXEMPT
    }


def test_no_class_function_or_module_has_a_name_that_is_ruled_out() -> None:
    names = _ruled_out()
    assert {"Outlet", "conduct", "true_torque"} <= names
    found = {
        f"{place}: {name}"
        for place, source in _sources().items()
        for name in (Path(place).stem, *_DEFINED.findall(source))
        if name in names
    }
    assert found == set()


def test_no_word_that_is_ruled_out_is_written() -> None:
    found = {f"{place}: {text}" for place, source in _sources().items() for text in _written(source)}
    assert found == set(), "docs/reference/glossary.md lists plain words"


@pytest.mark.parametrize("text", ["# whoever", "test_x_tells_nobody", "Slip\n    of the pen", "Nobody"])
def test_a_word_is_found_in_any_place(text: str) -> None:
    assert _written(text)


def _written(source: str) -> list[str]:
    """The phrases of a source as words or as parts of a snake_case name, also over the ends of lines."""
    text = source.lower()
    assert "whoever" in _phrases()
    found = (phrase for phrase in _phrases() if all(word in text for word in phrase.split()))
    return [phrase for phrase in found if _pattern(phrase).search(text)]
