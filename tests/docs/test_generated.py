"""The generated pages are those of their source, and have something to say on every key."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.document import Section, load_document
from benchtool.errors import PlanError, ProfileError
from benchtool.plan.model import Plan
from benchtool.profile import Profile
from docs.generate.__main__ import DOCS, main
from docs.generate.models import EXAMPLES, documents_of, tables
from docs.generate.pages import all_pages
from tests.docs import shell

WITHOUT_EXAMPLE = {"amplitude_V", "offset_V", "frame", "angle_rad", "omega_e_rad_s", "turn_s"}
"""Keys of a voltage stimulus, which no operating point of a plan plays yet."""


def test_the_pages_are_fresh() -> None:
    for name, text in all_pages().items():
        assert (DOCS / name).read_text(encoding="utf-8") == text, "run python -m docs.generate"


def test_a_stale_page_is_told_and_written_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "faults.md").write_text("stale", encoding="utf-8")
    assert main(["--check"], tmp_path) == 1
    assert "faults.md" in capsys.readouterr().err
    assert main([], tmp_path) == 0
    assert main(["--check"], tmp_path) == 0


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_examples_are_documents_that_load(path: Path) -> None:
    if path.stem.startswith("profile"):
        load_document(path, Profile, ProfileError)
    else:
        load_document(path, Plan, PlanError)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("plan*.toml")), ids=lambda path: path.stem)
def test_the_examples_of_plans_are_taken_by_a_run(path: Path) -> None:
    """Their names, units and windows as well: the page of the plan's keys quotes them."""
    shell.run(shell.Command(("benchtool", "run", str(path), "--dry-run"), 0))


@pytest.mark.parametrize("model", [Profile, Plan], ids=lambda model: model.__name__)
def test_every_key_has_an_example(model: type[Section]) -> None:
    found = list(tables(model, documents_of("profile" if model is Profile else "plan")))
    without = {
        f"{table.heading}: {key.name}"
        for table in found
        for key in table.keys
        if not key.example and not key.kind.endswith(("table", "tables", "at least 1"))
    }
    assert {each for each in without if each.split(": ")[-1] not in WITHOUT_EXAMPLE} == set()
    assert len({key.name for table in found for key in table.keys}) > 40
