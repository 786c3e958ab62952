"""`benchtool params dump | diff | load`: the parameters of a drive as a file."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.cli.params import advise, connected
from benchtool.drive.parameters import (
    Difference,
    aligned,
    as_held,
    compare,
    describe,
    parameters,
    read_parameter_file,
    render,
    require_disabled,
    settings,
    shipped_migrations,
    snapshot,
    write_all,
    write_parameter_file,
)
from benchtool.errors import ParameterFileError
from benchtool.protocol.dictionary import plain, shown

File = Annotated[Path, typer.Argument(metavar="FILE", help="Parameter file, as dump writes it.")]


def dump(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="File to write; standard output without one.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace FILE if it exists.")] = False,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Write every parameter to a TOML file that load takes back."""
    output = Output(as_json=as_json)
    if file is not None and file.exists() and not force:
        raise ParameterFileError(f"{file} exists: give another name, or --force to replace it")
    when = options.wall_time().isoformat(timespec="seconds")
    with connected(profile, link, output) as (drive, identity):
        content = describe(identity, snapshot(drive), when)
        text = render(content, drive.dictionary)
    if file is not None:
        write_parameter_file(file, text)
        output.line(f"{len(content.parameters)} parameters written to {file}")
    elif not as_json:
        sys.stdout.write(text)
    output.document(content.model_dump())
    return 0


def diff(
    first: Annotated[Path, typer.Argument(metavar="A", help="Parameter file.")],
    second: Annotated[
        Path | None, typer.Argument(metavar="[B]", help="Parameter file; the drive without one.")
    ] = None,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Compare a file with the drive, or two files; exit code 1 if they differ; a missing key does."""
    output = Output(as_json=as_json)
    ours = read_parameter_file(first)
    rules = shipped_migrations()
    if second is not None:
        name = str(second)
        ours, theirs = aligned(ours, read_parameter_file(second), rules)
    else:
        with connected(profile, link, output) as (drive, identity):
            name = "drive"
            ours, theirs = aligned(ours, describe(identity, snapshot(drive), ""), rules)
            ours = as_held(ours, drive.dictionary)
    found = compare(ours, theirs)
    _show(output, str(first), name, found)
    output.document(
        {"equal": not found, "a": str(first), "b": name, "differences": [asdict(each) for each in found]}
    )
    return 1 if found else 0


def load(
    file: File,
    with_address: Annotated[
        bool, typer.Option("--with-address", help="Also write node id and bit rate, if the file has them.")
    ] = False,
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Write the parameters of a file: checked first, each read back, all or none.

    On any failure the old values are restored. Only values that differ are written. The drive has to be
    disabled, and stores nothing until save.
    """

    output = Output(as_json=as_json)
    content = read_parameter_file(file)
    with connected(profile, link, output) as (drive, identity):
        dictionary = drive.dictionary
        wanted = settings(
            content, str(file), dictionary, identity, shipped_migrations(), with_address=with_address
        )
        require_disabled(drive, "a file is loaded")
        changed = {
            name: value
            for name, value in wanted.items()
            if drive.read(name) != dictionary[name].decode(dictionary[name].encode(value))
        }
        before = write_all(drive, changed)
        after = {name: drive.read(name) for name in changed}
        absent = [each.name for each in parameters(dictionary) if each.name not in wanted]
    for name, value in after.items():
        output.line(f"{name}: {shown(before[name])} → {shown(value)} {dictionary[name].unit}".rstrip())
    output.line(f"{len(changed)} of {len(wanted)} parameters changed, all are as in {file}")
    if absent:
        output.sentence(f"left as they were: {', '.join(absent)}", "yellow")
    advise(output, link, "not stored; benchtool params save keeps it over a reset")
    output.document(
        {
            "changed": {name: {"before": plain(before[name]), "value": plain(after[name])} for name in after},
            "loaded": len(wanted),
            "left_as_they_were": absent,
        }
    )
    return 0


def _show(output: Output, first: str, second: str, found: tuple[Difference, ...]) -> None:
    if not found:
        output.line(f"{first} and {second} are equal", "green")
        return
    output.line(f"{first} and {second} differ in {len(found)} keys", "bold")
    output.table(
        "",
        ("key", f">{first}", f">{second}"),
        [(each.key, _side(each.a, "red"), _side(each.b, "green")) for each in found],
    )


def _side(value: int | float | str | None, colour: str) -> Text:
    return Text("missing", "yellow") if value is None else Text(shown(value), colour)
