"""`benchtool params list | get | set | save | restore`: the parameters of a drive."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Annotated

import typer

from benchtool.bench import open_session
from benchtool.cli import options, proposals
from benchtool.cli.output import Output
from benchtool.drive import Identity, RemoteDrive
from benchtool.drive.parameters import (
    Parameter,
    overview,
    parameter,
    readable,
    restore_defaults,
    snapshot,
    store,
    write_all,
)
from benchtool.errors import ValueRefused, of_each
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import (
    Dictionary,
    Value,
    Variable,
    parse_value,
    plain,
    setting_of,
    shown,
    variable_of,
)

Names = Annotated[
    list[str],
    typer.Argument(metavar="NAME", help="Name, TOML key or 0xINDEX:SUB.", autocompletion=proposals.objects),
]
Assignments = Annotated[
    list[str],
    typer.Argument(
        metavar="NAME=VALUE",
        help="'R_s=123mohm', or 'R_s 123 mohm' for a single one.",
        autocompletion=proposals.assignments,
    ),
]


@contextmanager
def connected(profile: str, link: str, output: Output) -> Iterator[tuple[RemoteDrive, Identity]]:
    """The drive of a profile, checked against its dictionary; nothing is written to it."""
    with open_session(profile, link, note=output.note, instruments=False) as session:
        identity = session.drive.identify()
        identity.require(session.drive.dictionary, session.drive.dictionary.source)
        yield session.drive, identity


def list_(
    pattern: Annotated[
        str,
        typer.Argument(
            metavar="[PATTERN]",
            help="Part of a name, or a pattern with * and ?.",
            autocompletion=proposals.parameters,
        ),
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
        found = overview(drive, pattern)
        source, warnings = drive.dictionary.source, drive.dictionary.warnings
    for warning in warnings:
        output.note(f"{source}: {warning}")
    for each in found:
        output.line(_headline(each), "bold" if each.differs else "")
        output.sentence(each.about, "dim", lead="    ")
    differing = sum(each.differs for each in found)
    output.sentence(f"{len(found)} parameters; the {differing} with * differ from their default")
    output.document({"parameters": [each.to_json() for each in found], "warnings": list(warnings)})
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
        variables = of_each(partial(readable, drive.dictionary), names)
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
        assigned = of_each(partial(_assigned, drive.dictionary), pairs(assignments))
        units = {variable.name: variable.unit for variable, _ in assigned}
        values = {variable.name: value for variable, value in assigned}
        for name, count in Counter(variable.name for variable, _ in assigned).items():
            if count > 1:
                raise ValueRefused(f"'{name}' is given twice: give it once; nothing was sent")
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
    from_profile: Annotated[
        bool, typer.Option("--from-profile", help="Then write what the profile states: motor and parameters.")
    ] = False,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Set every parameter to its default: stored values are cleared (object 0x1011) and the drive is reset.

    The defaults are those of the dictionary and fit no motor: --from-profile writes those of the profile.
    """

    output = Output(as_json=as_json)
    with connected(profile, link, output) as (drive, _):
        values = restore_defaults(drive)
        if from_profile:
            stated = known_settings(drive.dictionary, load_profile(profile).stated_parameters)
            write_all(drive, {name: value for name, (_, value) in stated.items()})
            values |= {name: drive.read(name) for name in stated}
    output.sentence(f"{len(values)} parameters have their defaults, and the drive was reset")
    if from_profile:
        output.sentence(f"{len(stated)} of them were then set to what profile {profile} states")
        advise(output, link, "not stored; benchtool params save keeps it over a reset")
    else:
        advise(
            output,
            link,
            "the defaults fit no motor: 'params restore --from-profile' writes what the profile states, "
            "'params derive --write' what is derived from its motor",
        )
    output.document({"restored": True, "parameters": {name: plain(each) for name, each in values.items()}})
    return 0


# ---- shared by the commands ---------------------------------------------------------------------------


def pairs(tokens: Sequence[str]) -> list[tuple[str, str]]:
    """Return the names and texts of `A=1 mohm B=2`, or of the one assignment `A 1 mohm`.

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


def _assigned(dictionary: Dictionary, pair: tuple[str, str]) -> tuple[Variable, Value]:
    """Return the parameter that a name and a text are of, and its value.

    Raises:
        ValueRefused: there is no such parameter, or it cannot have this value.
    """
    name, text = pair
    variable = parameter(dictionary, name)
    value = parse_value(variable, text)
    variable.encode(value)
    return variable, value


def known_settings(
    dictionary: Dictionary, settings: Mapping[str, float | str]
) -> dict[str, tuple[str, Value]]:
    """Return those of some settings, by TOML key, that a drive has: key and value by the name of the
    variable.

    Raises:
        ValueRefused: it has none of them, or one cannot have its value.
    """
    found: dict[str, tuple[str, Value]] = {}
    for key, value in settings.items():
        try:
            variable = variable_of(dictionary, key)
        except ValueRefused:
            continue
        setting_of(dictionary, key, value)
        found[variable.name] = (key, value)
    if not found:
        raise ValueRefused(
            f"{dictionary.source} has none of {', '.join(settings)}: the maker's tool sets up this drive"
        )
    return found


def advise(output: Output, link: str, text: str) -> None:
    """Print a hint on standard error: values are lost without save, or at the end of an emulated drive."""
    if link.partition("?")[0] == "emulated":
        text = "an emulated drive lives as long as its command: nothing of this is kept"
    if text:
        output.note(text)


def _headline(each: Parameter) -> str:
    mark = "*" if each.differs else " "
    value = f"{each.shown} {each.unit}".rstrip()
    default = "" if each.default is None else f"default {shown(each.default)}"
    return f"{mark} {each.name:<23} {value:<16} {default:<16} {each.variable.label} {each.access}"
