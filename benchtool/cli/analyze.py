"""`benchtool analyze RUN`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchtool.cli import options
from benchtool.cli.output import Output, show_run


def analyze(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run bundle.")],
    as_json: options.Json = False,
) -> int:
    """Measure a recorded run again, by the plan that it carries."""
    from benchtool.experiment.assessment import RunResult, assess_bundle
    from benchtool.experiment.limits import Verdict
    from benchtool.recording import Bundle

    bundle = Bundle.open(run)
    result = RunResult((assess_bundle(bundle),))
    output = Output(as_json=as_json)
    show_run(output, bundle.manifest.what, result)
    output.document(result.to_json())
    return 1 if result.verdict is Verdict.FAIL else 0
