"""Provenance in a report: of a run, its drive and its plan."""

from __future__ import annotations

import pytest

from benchtool.profile import Choice
from benchtool.recording import Manifest
from benchtool.report.content import Grid
from benchtool.report.provenance import (
    choices_section,
    parameters_section,
    plan_section,
    run_facts,
    supervision_notes,
)

WHEN = "2026-11-21T12:00:00+00:00"


@pytest.mark.parametrize(
    ("words", "link"),
    [
        (("run", "x", "--link", "can:slcan:/dev/ttyACM0"), "can:slcan:/dev/ttyACM0"),
        (("run", "x", "--link=replay:DIR"), "replay:DIR"),
        (("run", "x"), None),
        (("run", "--link"), None),
        ((), None),
    ],
)
def test_the_link_is_that_of_the_command_line(words: tuple[str, ...], link: str | None) -> None:
    assert dict(run_facts(Manifest(what="x", when=WHEN, command_line=words)).pairs).get("link") == link


def test_without_a_word_of_the_link_an_emulated_drive_says_what_it_is() -> None:
    manifest = Manifest(what="x", when=WHEN, identity={"hardware_version": "emulated"}, dictionary_hash=0x1A)
    facts = dict(run_facts(manifest).pairs)
    assert facts["link"] == "emulated"
    assert facts["dictionary"] == "0x0000001A"
    assert "seed" not in facts


def test_parameters_that_differ_from_their_default_are_marked() -> None:
    described = {"u_s_V": ("u_s", "V", 50.0), "T_k_ratio": ("T_k_ratio", "", 0.7), "law": ("law", "", "tpc")}
    held = {"u_s_V": 81.65, "T_k_ratio": 0.699999988, "law": "tpc", "new_A": 1}
    (grid,) = parameters_section(held, described).items
    assert isinstance(grid, Grid)
    assert [[cell.text for cell in row] for row in grid.rows] == [
        ["u_s", "81.65", "V", "50", "differs"],
        ["T_k_ratio", "0.7", "", "0.7", ""],
        ["law", "tpc", "", "tpc", ""],
        ["new_A", "1", "", "", ""],
    ]
    (plain,) = parameters_section(held, {}).items
    assert isinstance(plain, Grid)
    assert len(plain.columns) == 2


def test_a_plan_is_listed_by_its_keys_and_what_is_empty_left_out() -> None:
    plan = {
        "title": "t",
        "setup": {"law": "tpc"},
        "stimulus": None,
        "variants": [{"name": "warm", "setup": {"R_s_ohm": 0.17}}],
        "record": {"channels": ["i_a", "torque"], "stride": 1},
        "readings": ["as in the paper"],
    }
    grid, reading = plan_section(plan).items
    assert isinstance(grid, Grid)
    assert [[cell.text for cell in row] for row in grid.rows] == [
        ["setup.law", "tpc"],
        ["variants", "{ name = warm, setup.R_s_ohm = 0.17 }"],
        ["record.channels", "i_a, torque"],
        ["record.stride", "1"],
    ]
    assert getattr(reading, "text", "") == "as in the paper"


def test_choices_are_listed_if_there_are_any() -> None:
    assert choices_section(()) is None
    section = choices_section([Choice(about="a", choice="b", reason="c", effect="d")])
    assert section is not None
    (grid,) = section.items
    assert isinstance(grid, Grid)
    assert [cell.text for cell in grid.rows[0]] == ["a", "b", "c", "d"]


def test_how_a_drive_was_supervised_is_said_once_where_the_profile_lets_it_run_without() -> None:
    def manifest(**details: object) -> Manifest:
        return Manifest(what="x", when=WHEN, details=details)

    armed = manifest(supervision={"armed": True, "reason": ""})
    without = manifest(supervision={"armed": False, "reason": "no 0x1016:1"})
    assert list(supervision_notes([manifest(), manifest(supervision="?")])) == []
    kept, ran = supervision_notes([armed, without, without, armed])
    assert (kept.kind, ran.kind) == ("note", "warning")
    assert kept.text.endswith("it was supervised.")
    assert ran.text.endswith("Reason: no 0x1016:1.")
