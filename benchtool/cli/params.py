"""`benchtool params list | get | set | save | restore`: the parameters of a drive."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import typer

from benchtool.bench.session import open_session
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.drive import Identity, RemoteDrive
from benchtool.drive.parameters.file import about
from benchtool.drive.parameters.storage import restore_defaults, store
from benchtool.drive.parameters.transaction import (
    default_of,
    named,
    parameter,
    parameters,
    snapshot,
    write_all,
)
from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary.quantity import parse_value
from benchtool.protocol.dictionary.variable import Value, Variable

Names = Annotated[list[str], typer.Argument(metavar="NAME", help="Name, TOML key or 0xINDEX:SUB.")]
Assignments = Annotated[
    list[str],
    typer.Argument(metavar="NAME=VALUE", help="'R_s=123mohm', or 'R_s 123 mohm' for a single one."),
]


@contextmanager
def connected(profile: str, link: str, output: Output) -> Iterator[tuple[RemoteDrive, Identity]]:
    """The drive of a profile, known to speak its dictionary; nothing is written to it."""
    with open_session(profile, link, note=output.note, instruments=False) as session:
        identity = session.drive.identify()
        identity.require(session.drive.dictionary, session.drive.dictionary.source)
        yield session.drive, identity


def list_(
    pattern: Annotated[
        str, typer.Argument(metavar="[PATTERN]", help="Part of a name, or a pattern with * and ?.")
    ] = "",
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Every parameter with value, unit, limits and default; '*' marks what differs from its default.

    'rw if off' can be written with the power stage off only.
    """

    output = Output(as_json=as_json)
    with connected(profile, link, output) as (drive, _):
        chosen = [each for each in parameters(drive.dictionary) if _matches(each.name, pattern)]
        if not chosen:
            raise ValueRefused(f"no parameter matches '{pattern}': see benchtool params list")
        facts = [_facts(variable, drive.read(variable.name)) for variable in chosen]
        source, warnings = drive.dictionary.source, drive.dictionary.warnings
    for warning in warnings:
        output.note(f"{source}: {warning}")
    for variable, each in zip(chosen, facts, strict=True):
        output.line(_headline(each), "bold" if each["differs"] else "")
        output.line(f"    {about(variable)}", "dim")
    differing = sum(each["differs"] for each in facts)
    output.line(f"{len(facts)} parameters; the {differing} with * differ from their default")
    output.document({"parameters": facts, "warnings": list(warnings)})
    return 0


def get(
    names: Names,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Read objects of any kind by name."""
    output = Output(as_json=as_json)
    with connected(profile, link, output) as (drive, _):
        variables = [_readable(drive, name) for name in names]
        values = {variable.name: drive.read(variable.name) for variable in variables}
    units = {variable.name: variable.unit for variable in variables}
    for name, value in values.items():
        output.line(f"{name} = {shown(value)} {units[name]}".rstrip())
    output.document({name: {"value": plain(value), "unit": units[name]} for name, value in values.items()})
    return 0


def set_(
    assignments: Assignments,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Write parameters: all are checked before the first is sent, each is read back, all or none hold.

    A value that begins with a minus sign needs the form NAME=VALUE.
    """

    output = Output(as_json=as_json)
    with connected(profile, link, output) as (drive, _):
        values: dict[str, Value] = {}
        units: dict[str, str] = {}
        for name, text in pairs(assignments):
            variable = parameter(drive.dictionary, name)
            if variable.name in values:
                raise ValueRefused(f"'{variable.name}' is given twice: give it once; nothing was sent")
            values[variable.name] = parse_value(variable, text)
            units[variable.name] = variable.unit
        before = write_all(drive, values)
        after = {name: drive.read(name) for name in values}
    for name, value in after.items():
        output.line(f"{name}: {shown(before[name])} → {shown(value)} {units[name]}".rstrip())
    advise(output, link, "not stored; benchtool params save keeps it over a reset")
    output.document(
        {
            name: {"before": plain(before[name]), "value": plain(value), "unit": units[name]}
            for name, value in after.items()
        }
    )
    return 0


def save(
    profile: options.Profile = "zhu2011", link: options.Link = "emulated", as_json: options.Json = False
) -> int:
    """Have the drive store its parameters, so that they survive a reset and power off (object 0x1010)."""
    output = Output(as_json=as_json)
    with connected(profile, link, output) as (drive, _):
        values = snapshot(drive)
        store(drive)
    output.line(f"{len(values)} parameters stored")
    advise(output, link, "")
    output.document({"stored": True, "parameters": values})
    return 0


def restore(
    profile: options.Profile = "zhu2011", link: options.Link = "emulated", as_json: options.Json = False
) -> int:
    """Set every parameter to its default: the drive forgets what it stored (object 0x1011) and is reset.

    The defaults are those of the dictionary and fit no motor: load or set the motor's before enabling.
    """

    output = Output(as_json=as_json)
    with connected(profile, link, output) as (drive, _):
        values = restore_defaults(drive)
    output.line(f"{len(values)} parameters have their defaults, and the drive was reset")
    advise(output, link, "the defaults fit no motor; load or set the motor's parameters before enabling")
    output.document({"restored": True, "parameters": {name: plain(each) for name, each in values.items()}})
    return 0


# ---- shared by the commands ---------------------------------------------------------------------------


def pairs(tokens: Sequence[str]) -> list[tuple[str, str]]:
    """Names and texts of `A=1 mohm B=2`, or of the one assignment `A 1 mohm`.

    Raises:
        ValueRefused: a name without a value, or a value without a name.
    """
    if tokens and not any("=" in token for token in tokens):
        tokens = [f"{tokens[0]}={' '.join(tokens[1:])}"]
    found: list[tuple[str, str]] = []
    for token in tokens:
        name, equals, text = token.partition("=")
        if equals:
            found.append((name.strip(), text))
        elif found:
            found[-1] = (found[-1][0], f"{found[-1][1]} {token}")
        else:
            raise ValueRefused(
                f"'{token}' stands before the first NAME=VALUE: give its value as '{token}=...'"
            )
    for name, text in found:
        if not name or not text.strip():
            raise ValueRefused(
                f"'{name}={text}' is not an assignment: NAME=VALUE is expected, such as R_s=123mohm"
            )
    return found


def advise(output: Output, link: str, text: str) -> None:
    """A hint on standard error; of an emulated drive, that it forgets."""
    if link.partition("?")[0] == "emulated":
        text = "an emulated drive lives as long as its command: nothing of this is kept"
    if text:
        output.note(text)


def shown(value: Value) -> str:
    """A value for people."""
    if isinstance(value, bytes):
        return value.hex(" ")
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def plain(value: Value) -> int | float | str:
    """A value for JSON, which has neither bytes nor nan."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value.hex() if isinstance(value, bytes) else value


def _readable(drive: RemoteDrive, name: str) -> Variable:
    variable = named(drive.dictionary, name)
    if not variable.readable:
        raise ValueRefused(f"'{variable.name}' is write-only: it cannot be read")
    return variable


def _matches(name: str, pattern: str) -> bool:
    wanted = pattern.lower()
    return fnmatch.fnmatchcase(name.lower(), wanted) if set(wanted) & set("*?[") else wanted in name.lower()


def _facts(variable: Variable, value: Value) -> dict[str, Any]:
    default = default_of(variable)
    return {
        "name": variable.name,
        "index": variable.label,
        "value": plain(value),
        "unit": variable.unit,
        "minimum": variable.minimum,
        "maximum": variable.maximum,
        "values": list(variable.values) if variable.values is not None else None,
        "default": None if default is None else plain(default),
        "differs": default is not None and value != default,
        "access": variable.access,
        "enabled_write": variable.enabled_write,
        "description": variable.description,
    }


def _headline(facts: dict[str, Any]) -> str:
    mark = "*" if facts["differs"] else " "
    value = f"{shown(facts['value'])} {facts['unit']}".rstrip()
    default = "" if facts["default"] is None else f"default {shown(facts['default'])}"
    access = facts["access"] if facts["enabled_write"] else f"{facts['access']} if off"
    return f"{mark} {facts['name']:<23} {value:<16} {default:<16} {facts['index']} {access}"
