"""`benchtool export RUN`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from benchtool.analysis import count_of
from benchtool.cli import options
from benchtool.cli.output import Output, warn_unsealed
from benchtool.recording import Bundle, Format, export as write
from benchtool.results import incomplete


class _Format(StrEnum):
    """As in `recording.export`, without importing what that needs."""

    csv = "csv"
    mat = "mat"
    mdf4 = "mdf4"


def export(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run bundle.")],
    format_: Annotated[_Format, typer.Option("--format", help="What to write.")] = _Format.csv,
    stream: Annotated[
        str, typer.Option(metavar="NAME", help="Which data.", show_default="capture, else the first")
    ] = "",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write.", show_default="<RUN>-<stream>")
    ] = None,
    as_json: options.Json = False,
) -> int:
    """Write the data of a run for other tools: CSV, MATLAB or MDF4, with units and every bit."""
    output = Output(as_json=as_json)
    bundle = Bundle.open(run)
    bundle.require_intact()
    warn_unsealed(output, [bundle])
    if text := incomplete(run, [("", bundle)]):
        output.warning(text)
    wanted = Format(format_.value)
    name = stream or next(
        (each for each in ("capture", *bundle.streams) if each in bundle.streams), "telemetry"
    )
    path = out or Path(f"{run.resolve().name}-{name}{wanted.suffix}")
    block = write(bundle, name, wanted, path)
    missing = sum(gap.missing_rows for gap in block.gaps)
    output.line(
        f"{path}: {count_of(len(block.data), 'row')} of {count_of(len(block.channels), 'channel')}, "
        f"{missing} missing"
    )
    output.document(
        {
            "file": str(path),
            "format": str(wanted),
            "stream": name,
            "rows": len(block.data),
            "missing_rows": missing,
            "channels": {each.name: each.unit for each in block.channels},
        }
    )
    return 0
