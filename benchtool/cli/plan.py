"""`benchtool plan new`: a test plan of one's own."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.cli.new_files import write_new
from benchtool.cli.output import Output
from benchtool.plan import plan_text
from benchtool.profile import load_profile


def new(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="TOML file to write; standard output without one.")
    ] = None,
    profile: options.Profile = "zhu2011",
    title: Annotated[str, typer.Option(help="What a report calls the test.")] = "",
    force: Annotated[bool, typer.Option("--force", help="Replace FILE if it exists.")] = False,
    as_json: options.Json = False,
) -> int:
    """A commented plan that runs as it stands: torque ripple at half the rated speed and torque."""
    output = Output(as_json=as_json)
    stated = load_profile(profile)
    named = profile
    if profile.endswith(".toml"):
        folder = Path.cwd() if file is None else file.resolve().parent
        named = Path(os.path.relpath(Path(profile).resolve(), folder)).as_posix()
    text = plan_text(title or f"Torque ripple of {stated.title} at half load", named, stated)
    write_new(file, text, force=force, quiet=as_json)
    if file is not None:
        output.line(f"plan written to {file}")
        output.note(f"benchtool run {file} --dry-run shows what it does, benchtool run {file} does it")
    output.document({"file": None if file is None else str(file), "profile": named})
    return 0
