"""`benchtool verify RUN`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.results import verify_run


def verify(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN|REPORT", help="Run bundle, folder of several, or a report in one of these."
        ),
    ],
    as_json: options.Json = False,
) -> int:
    """Compare every file of a run with its hash, and measure the raw data again: all numbers, to the bit."""
    output = Output(as_json=as_json)
    found = verify_run(run)
    for name, reason in found.damaged.items():
        output.line(f"{found.folder / name}: {reason}", style="red")
    for name, reason in found.different.items():
        output.line(f"{name}: {reason}", style="red")
    for name, reason in found.not_recomputed.items():
        if not found.damaged:
            output.note(f"{found.folder / name}: not measured again: {reason}")
    if found.unlisted:
        output.note(f"without a hash, not verified: {', '.join(found.unlisted)}")
    if not found.sealed:
        output.line(f"{found.folder}: recorded without hashes, by an earlier version", style="red")
    output.sentence(
        f"{found.files} files fit their hashes, {len(found.damaged)} do not; {found.recomputed} results were "
        f"measured again to the bit, {len(found.different)} differ"
    )
    for text in found.incomplete:
        output.warning(text)
    verdict = "pass" if found.holds else "fail"
    output.verdict(verdict)
    output.document(
        {
            "verdict": verdict,
            "folder": str(found.folder),
            "files": found.files,
            "recomputed": found.recomputed,
            "damaged": dict(found.damaged),
            "different": dict(found.different),
            "not_recomputed": dict(found.not_recomputed),
            "unlisted": list(found.unlisted),
            "incomplete": list(found.incomplete),
        }
    )
    return 0 if found.holds else 1
