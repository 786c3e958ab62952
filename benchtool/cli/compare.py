"""`benchtool compare RUN RUN ...`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchtool.cli import options
from benchtool.cli.output import Output, show_side_by_side

if TYPE_CHECKING:
    from benchtool.experiment.assessment import Assessment


def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN...", help="Run bundles, or folders of a run of several cases."),
    ],
    as_json: options.Json = False,
) -> int:
    """Measure recorded runs again and set them side by side."""
    output = Output(as_json=as_json)
    cases = [_named(case, run, runs) for run in runs for case in _cases(run)]
    show_side_by_side(output, "comparison", cases)
    output.document({"cases": {case.case: case.to_json() for case in cases}})
    return 0


def _cases(run: Path) -> list[Assessment]:
    from benchtool.errors import RecordingError
    from benchtool.experiment.assessment import assess_bundle
    from benchtool.recording import Bundle

    if (run / "manifest.json").is_file():
        return [assess_bundle(Bundle.open(run))]
    bundles = [Bundle.open(path.parent) for path in sorted(run.glob("*/manifest.json"))]
    complete = [bundle for bundle in bundles if bundle.complete]
    if not complete:
        raise RecordingError(f"{run} holds no complete run bundle: give the folder of a run")
    return [assess_bundle(bundle) for bundle in sorted(complete, key=lambda bundle: bundle.manifest.when)]


def _named(case: Assessment, run: Path, runs: list[Path]) -> Assessment:
    """The case under a name that tells it from those of other runs."""
    from dataclasses import replace

    return case if len(runs) == 1 else replace(case, case=f"{run.name}:{case.case}")
