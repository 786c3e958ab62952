"""One sentence on a run that did not come to its end, whichever command reads it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from benchtool.recording import Bundle
from benchtool.results.incomplete import cut_short, incomplete

RUN = Path("runs/laws")


def bundle(
    *, complete: bool = True, planned: bool = True, failure: str = "", plan: str = "laws.toml"
) -> Bundle:
    details: dict[str, object] = ({"plan": {}} if planned else {}) | ({"failure": failure} if failure else {})
    manifest = SimpleNamespace(details=details, command_line=("run", plan) if plan else ("demo",))
    return cast(Bundle, SimpleNamespace(complete=complete, manifest=manifest))


def test_a_complete_run_is_not_spoken_of() -> None:
    assert cut_short(bundle()) == incomplete(RUN, [("a", bundle())]) == ""


def test_a_killed_run_of_several_cases_says_what_is_there_and_how_it_goes_on() -> None:
    found = incomplete(RUN, [("a", bundle()), ("b", bundle(complete=False))], ["c", "d", "e", "f", "g", "h"])
    assert found == (
        "runs/laws is incomplete: 1 of 8 cases are complete; b was cut short (its process ended); without a "
        "recording: c, d, e, f and 2 more; 'benchtool run laws.toml --resume runs/laws' goes on"
    )


@pytest.mark.parametrize(
    ("one", "rest"),
    [
        (
            bundle(complete=False, failure="DriveFault"),
            "(DriveFault), what was recorded until then is there; ",
        ),
        (bundle(complete=False, plan=""), "'benchtool run PLAN --resume runs/laws' goes on"),
        (bundle(complete=False, planned=False), "(its process ended), what was recorded until then is there"),
    ],
)
def test_a_bundle_that_was_cut_short_says_why(one: Bundle, rest: str) -> None:
    found = incomplete(RUN, [("a", one)])
    assert found.startswith("runs/laws is incomplete: it was cut short (")
    assert rest in found
    assert ("--resume" in found) == ("plan" in one.manifest.details)
