"""TOML documents checked against a pydantic model, with errors that name file, line and key."""

from __future__ import annotations

import difflib
import itertools
import json
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Generic, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Strict, ValidationError
from pydantic_core import ErrorDetails

from benchtool.errors import MOST_REASONS, UsageError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.misfits import Path_, described, is_misspelt, key_meant, misfits

_OF_64_BITS = 1 << 63
Item = TypeVar("Item")
Array = Annotated[tuple[Item, ...], Strict(False)]
"""An array of TOML or JSON, which is a list when it is read, as a tuple."""

_SHORT_LIST = 24
_WIDEST = 44  # column of comments
_PART = r"""(?:"[^"]*"|'[^']*'|[\w-]+)"""
_KEYS = rf"{_PART}(?:\s*\.\s*{_PART})*"


class Section(BaseModel):
    """A table of a document: unknown keys are refused, values cannot be changed afterwards.

    Values are of the type that is asked for: `true` and `"15.71"` are not numbers. A whole number is a float.
    """

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        arbitrary_types_allowed=True,
        strict=True,
        defer_build=True,
    )


Model = TypeVar("Model", bound=Section)


def defaults(model: type[Model]) -> Model:
    """Return a table without keys, as `model()`, whose check is not built for it: that takes longest of all
    that a document's modules do when they are imported."""
    return model.model_construct()


def document_path(
    name: str,
    place: Path | None,
    kind: FileKind,
    names: Callable[[], Sequence[str]],
    error: type[UsageError],
) -> Path:
    """Return the file that `name` names: a path ending in .toml, else `place`, where a document of that name
    ships.

    Raises:
        error: there is none; the message names the nearest of `names()`, and all of them.
    """
    given = Path(name)
    if given.suffix == ".toml":
        if given.is_file():
            return given
        raise error(f"no {kind} file {given}: give an existing TOML file or a name ({', '.join(names())})")
    if place is None or not place.is_file():
        if told := mistaken(given, kind):
            raise error(told)
        if (beside := Path(f"{name}.toml")).is_file():
            raise error(f"no {kind} ships by the name '{name}': did you mean the file '{beside}'?")
        raise error(f"no {kind} '{name}': {closest(name, names())}; or give a TOML file")
    return place


def closest(name: str, names: Sequence[str]) -> str:
    """`did you mean 'x'?` where one of `names` is like `name`, and all of them unless that makes it long."""
    close = difflib.get_close_matches(name, names, n=1)
    meant = f"did you mean '{close[0]}'? " if close else ""
    if close and len(names) > _SHORT_LIST:
        return meant.rstrip()
    return f"{meant}the names are {', '.join(names)}"


Faults = Iterable[tuple[Path_, str]]
"""Places of a document, and what is wrong there."""


@dataclass(frozen=True)
class Further(Generic[Model]):
    """What else is wrong in a document of which something does not fit the model: `faults` of the rest, in
    which the places of the second argument are left out.

    `stand_in` has values that nothing is wrong with, for those that a document needs and that are left out.
    """

    faults: Callable[[Model, frozenset[Path_]], Faults]
    stand_in: Mapping[str, Any]


def load_document(
    path: Path,
    model: type[Model],
    error: type[UsageError],
    change: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda content: content,
    further: Further[Model] | None = None,
    *,
    kind: FileKind | None = None,
) -> Model:
    """Return the document at `path` as `model`.

    Args:
        change: may alter what the file has before that is checked.
        further: how all that is wrong is told at once, where something does not fit the model.
        kind: what the file is to be, so that one of another kind is told as such.

    Raises:
        error: the file cannot be read, is not TOML, or does not fit the model; one line each.
    """
    return parse_document(read_document(path, error), path, model, error, change, further, kind=kind)


def read_document(path: Path, error: type[UsageError]) -> str:
    """Return the text of the document at `path`.

    Raises:
        error: the file cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as reason:
        raise error(f"cannot read {path}: {_reason(reason)}; a readable TOML file is expected") from None


def parse_document(
    text: str,
    path: Path,
    model: type[Model],
    error: type[UsageError],
    change: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda content: content,
    further: Further[Model] | None = None,
    *,
    kind: FileKind | None = None,
) -> Model:
    """As `load_document`, of a text that has been read from `path`."""
    try:
        return _parsed(text, path, model, error, change, further)
    except error:
        if kind is not None and (told := mistaken(path, kind)):
            raise error(told) from None
        raise


def _parsed(
    text: str,
    path: Path,
    model: type[Model],
    error: type[UsageError],
    change: Callable[[Mapping[str, Any]], Mapping[str, Any]],
    further: Further[Model] | None,
) -> Model:
    """Return a text as a document.

    Raises:
        error: it is not TOML, or does not fit the model.
    """
    try:
        content = tomllib.loads(text)
        _require_64_bits(content)
    except tomllib.TOMLDecodeError as reason:
        raise error(f"{path}: not TOML: {reason}; correct that line") from None
    except ValueError:  # of thousands of digits, which Python does not convert, or of more than 64 bits
        raise error(
            f"{path}: a whole number has more digits than can be read, 18 at most are expected: correct it"
        ) from None
    except RecursionError:
        raise error(
            f"{path}: tables or lists lie deeper in each other than can be read, some levels are expected: "
            f"take the nesting out"
        ) from None
    checked = _Checked.of(model, change(content), {} if further is None else further.stand_in)
    if checked.rest is not None and not checked.wrong:
        return checked.rest
    reasons = [(place, described(model, detail)) for place, detail in checked.wrong[:MOST_REASONS]]
    if further is not None and checked.rest is not None:
        rest = further.faults(checked.rest, checked.left_out)
        reasons += [each for each in rest if not checked.follows(each[0])]
    told = dict.fromkeys(
        f"{path}{line_of(text, place)}: {reason}" for place, reason in by_line(text, reasons)
    )
    raise error.of_all(list(told), max(len(told), len(checked.wrong)))


@dataclass(frozen=True)
class _Checked(Generic[Model]):
    """What is `wrong` in a document, the places that are `left_out` for it, and the `rest`; None where that
    is no document."""

    wrong: list[tuple[Path_, ErrorDetails]]
    left_out: frozenset[Path_]
    rest: Model | None

    @classmethod
    def of(cls, model: type[Model], content: Mapping[str, Any], stand_in: Mapping[str, Any]) -> Self:
        """Check content.

        A table is looked at as a whole once its keys are right. So misspelt keys are taken for those that
        they are like, what else is wrong is left out, and the rest is looked at again; values that it needs
        are those of `stand_in` then.
        """
        wrong: list[tuple[Path_, ErrorDetails]] = []
        found = cls(wrong, frozenset(), None)
        while True:
            try:
                return replace(found, rest=model.model_validate(content))
            except ValidationError as failed:
                new = [each for each in misfits(model, failed) if not found.follows(each[0])]
            wrong += new
            before = content
            for place, detail in sorted(new, key=_later) if len(wrong) <= MOST_REASONS else ():
                misspelt = is_misspelt(detail)
                content = _corrected(content, place, key_meant(model, detail) if misspelt else "")
                found = found if misspelt else replace(found, left_out=found.left_out | {place})
            for place in (
                found.left_out if content is before else ()
            ):  # a missing key is not corrected, and filled in
                content = _filled(content, place, stand_in)
            if content is before:
                return found

    def follows(self, place: Path_) -> bool:
        """Return whether something is left out at a place or in the table there, so that what is wrong with
        that may follow from it."""
        return any(out[: len(place)] == place for out in self.left_out)


def _later(wrong: tuple[Path_, ErrorDetails]) -> tuple[int, ...]:
    """Return the sort key by which what stands later in an array comes first, so that taking it out moves
    nothing that is to be taken out after it."""
    return tuple(-part for part in wrong[0] if isinstance(part, int))


def _corrected(content: Any, place: Path_, meant: str) -> Any:
    """Return content in which what stands at a place is called as it was `meant`, or is left out; the content
    itself where nothing stands there."""
    if not place or not isinstance(content, dict | list):
        return content
    first, *rest = place
    try:
        inner = content[first]  # type: ignore[index] # a place may be that of another form
    except (KeyError, IndexError, TypeError):
        return content
    within = _corrected(inner, tuple(rest), meant)
    if rest and within is inner:
        return content
    changed: Any = content.copy()
    if rest:
        changed[first] = within
    else:
        del changed[first]
        if meant:
            changed.setdefault(meant, inner)
    return changed


def _filled(content: Any, place: Path_, stand_in: Any) -> Any:
    """Return content with the value that `stand_in` has at a place; the content itself where it has one, or
    that has none."""
    if not (isinstance(content, Mapping) and isinstance(stand_in, Mapping) and place):
        return content
    first, *rest = place
    if first not in stand_in or (not rest and first in content):
        return content
    inner = content.get(first, {}) if rest else None
    within = _filled(inner, tuple(rest), stand_in[first]) if rest else stand_in[first]
    return content if rest and within is inner else {**content, first: within}


def _require_64_bits(content: object) -> None:
    """Raise ValueError where a whole number is outside the range of TOML (v1.0.0, integer)."""
    left = [content]
    while left:
        match left.pop():
            case Mapping() as table:
                left += table.values()
            case list() as values:
                left += values
            case int() as number if not -_OF_64_BITS <= number < _OF_64_BITS:
                raise ValueError


def _reason(reason: OSError | UnicodeDecodeError) -> str:
    return reason.strerror or str(reason) if isinstance(reason, OSError) else "it is not UTF-8 text"


def by_line(text: str, faults: Faults) -> list[tuple[Path_, str]]:
    """Return faults in the order of their lines; those whose place is not in the text last."""
    return sorted(faults, key=lambda fault: _line_number(text, fault[0]) or math.inf)


def line_of(text: str, location: Path_) -> str:
    """`, line N` of the assignment or the table that `location` names; empty where it is not in the text."""
    number = _line_number(text, location)
    return "" if number is None else f", line {number}"


def _line_number(text: str, location: Path_) -> int | None:
    """Return the number of the line of the assignment or the table that `location` names.

    A number in `location` counts the tables of an array (`[[variants]]`) from 0.
    """
    wanted = [part for part in location if isinstance(part, str)]
    counts = {str(name): at for name, at in itertools.pairwise(location) if isinstance(at, int)}
    table: list[str] = []
    seen: dict[str, int] = {}
    best: tuple[int, int] | None = None
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(rf"\s*(\[\[?)\s*({_KEYS})\s*\]", line)
        key = re.match(rf"\s*({_KEYS})\s*=", line)
        if header:
            table = _parts(header[2])
            if header[1] == "[[":
                seen[table[-1]] = seen.get(table[-1], -1) + 1
        elif not key:
            continue
        parts = table if header else table + _parts(key[1])  # type: ignore[index] # one of the two matched
        depth = min(len(parts), len(wanted))
        passed = any(seen.get(name, at) != at for name, at in counts.items() if name in parts)
        if parts[:depth] == wanted[:depth] and not passed and (best is None or depth > best[0]):
            best = (depth, number)
    return None if best is None else best[1]


def _parts(keys: str) -> list[str]:
    """Return the parts of a dotted key, without their quotes."""
    return [part.strip("\"'") for part in re.findall(_PART, keys)]


def unit_suffix(unit: str) -> str:
    """Return a unit as a key ends with it: `Nm`, `rad_s`, `percent`; empty of a pure number (`""` or
    `"1"`)."""
    return re.sub(r"\W+", "_", unit.replace("%", "percent")).strip("_").removeprefix("1")


Row = Sequence[float]
Literal = (
    float
    | str
    | bool
    | Sequence[str]
    | Row
    | Sequence[Row]
    | Mapping[str, float]
    | Mapping[str, Row | Sequence[Row]]
)


def commented_table(name: str, rows: Sequence[tuple[str, Literal, str]]) -> str:
    """Return a table of TOML, each key with its value and a comment; a key that begins with `#` is left
    out."""
    lines = [(f"{key.replace('#', '# ')} = {_literal(value)}", comment) for key, value, comment in rows]
    width = min(max(len(line) for line, _ in lines), _WIDEST) if lines else 0
    header = [f"[{name}]"] if name else []
    return "\n".join(
        (*header, *(f"{line:<{width}}  # {comment}" if comment else line for line, comment in lines), "")
    )


def _literal(value: Literal) -> str:
    """Return a value as TOML has it; numbers to six digits."""
    match value:
        case bool():
            return str(value).lower()
        case int():
            return str(value)
        case float():
            return f"{value:.6g}"
        case str():
            return json.dumps(value, ensure_ascii=False)
        case Mapping():
            return f"{{ {', '.join(f'{key} = {_literal(each)}' for key, each in value.items())} }}"
        case _:
            return f"[{', '.join(_literal(each) for each in value)}]"
