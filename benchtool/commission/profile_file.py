"""A profile as a commissioning leaves it: the file it began with, its numbers replaced."""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping
from typing import Any, Final

from benchtool.analysis import Measurement
from benchtool.errors import ProfileError
from benchtool.protocol.dictionary import Value

_MOTOR: Final = ("pole_pairs", "R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2")
_HEADER: Final = re.compile(r"^\s*\[\s*([A-Za-z0-9_.]+)\s*\]")
_ENTRY: Final = re.compile(r"^(\s*)([A-Za-z0-9_]+)(\s*=\s*)([^#\"']*?|\"[^\"]*\")(\s*)(#.*)?$")


def commissioned_profile(
    text: str, values: Mapping[str, Value], estimates: Mapping[str, Measurement], *, saved: bool
) -> str:
    """Return the text of a profile with the values of a commissioning; its comments and all else stay.

    What `[motor]` stated until then goes into `[nameplate]`, unless there is one already, and behind each
    number that was estimated, with its expanded uncertainty. An emulated drive that has stored the values
    is commissioned.

    Args:
        text: of the profile that was commissioned with.
        values: by the keys of a profile.
        estimates: by the dictionary's names.
        saved: whether the drive has stored the values.

    Raises:
        ProfileError: the text writes its tables in a way that cannot be edited by lines.
    """
    before = tomllib.loads(text)
    motor = {key: values[key] for key in _MOTOR if key in values}
    stated = set(before["motor"])
    parameters = {
        key: value for key, value in values.items() if key not in stated and key != "motor_rated_current_A"
    }
    remarks = {key: _remark(key, estimates, before) for key in (*motor, *parameters)}
    lines = text.splitlines()
    lines = _edited(lines, "motor", motor, remarks)
    lines = _edited(lines, "drive.parameters", parameters, remarks)
    if saved:
        lines = _edited(lines, "emulator", {"commissioned": True}, {}, add=False)
    if "nameplate" not in before:
        lines += ["", "# What [motor] stated before this motor was commissioned.", "[nameplate]"]
        lines += [f"{key} = {_literal(value)}" for key, value in before["motor"].items()]
    written = "\n".join(lines) + "\n"
    _require_written(written, motor, parameters)
    return written


def _edited(
    lines: list[str], table: str, values: Mapping[str, Value], remarks: Mapping[str, str], *, add: bool = True
) -> list[str]:
    """Return lines with the values of one table; keys that it has not stand at its end."""
    found: list[str] = []
    left, inside, there = dict(values), False, False
    for line in lines:
        header = _HEADER.match(line)
        if line.lstrip().startswith("["):
            if inside and add:
                found = _with_more(found, left, remarks)
            inside = header is not None and header[1] == table
            there = there or inside
        elif inside and (entry := _ENTRY.match(line)) and entry[2] in left:
            key = entry[2]
            found.append(_line(key, left.pop(key), remarks.get(key, ""), entry[6] or ""))
            continue
        found.append(line)
    if inside and add:
        found = _with_more(found, left, remarks)
    elif not there and add and left:
        found += ["", f"[{table}]", *(_line(key, value, remarks.get(key, "")) for key, value in left.items())]
    return found


def _with_more(lines: list[str], left: dict[str, Value], remarks: Mapping[str, str]) -> list[str]:
    """Return lines with what is left, in front of the blank lines at their end."""
    at = len(lines)
    while at and (not lines[at - 1].strip() or lines[at - 1].lstrip().startswith("#")):
        at -= 1
    more = [_line(key, value, remarks.get(key, "")) for key, value in left.items()]
    left.clear()
    return [*lines[:at], *more, *lines[at:]]


def _line(key: str, value: Value, remark: str, comment: str = "") -> str:
    said = "; ".join(filter(None, (comment.lstrip("# "), remark)))
    return f"{key} = {_literal(value)}" + (f"  # {said}" if said else "")


def _literal(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case int():
            return str(value)
        case float():
            return f"{value:.7g}" if not value.is_integer() or abs(value) > 1e6 else f"{value:.1f}"
        case _:
            return json.dumps(str(value), ensure_ascii=False)


def _remark(key: str, estimates: Mapping[str, Measurement], before: Mapping[str, Any]) -> str:
    """Return what a comment says of a value that was estimated; empty of another."""
    name = next((each for each in estimates if key == each or key.startswith(f"{each}_")), "")
    found = estimates.get(name)
    if found is None or not math.isfinite(found.value):
        return ""
    remark = f"commissioned: {found.in_unit}"
    was = before["motor"].get(key)
    return f"{remark}, nameplate {was:g}" if isinstance(was, int | float) else remark


def _require_written(text: str, motor: Mapping[str, Value], parameters: Mapping[str, Value]) -> None:
    """Check that the text says what it should.

    Raises:
        ProfileError: it does not.
    """
    try:
        after = tomllib.loads(text)
        places = ((after["motor"], motor), (after["drive"]["parameters"], parameters))
        lost = [
            key
            for table, values in places
            for key, value in values.items()
            if not _same(table.get(key), value)
        ]
    except (ValueError, KeyError, TypeError):
        lost = [*motor, *parameters]
    if lost:
        raise ProfileError(
            f"{', '.join(lost)} could not be written into the profile: it is edited line by line, with "
            f"[motor] and [drive.parameters] as tables of one key a line; write it so"
        )


def _same(written: Any, value: Value) -> bool:
    if isinstance(written, int | float) and isinstance(value, int | float):
        return math.isclose(written, value, rel_tol=1e-6, abs_tol=1e-12)
    return bool(written == value)
