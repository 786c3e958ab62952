"""The index of the decisions: every page in one section, and a message that says where a new one goes."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.generate.decisions import FOLDER, SECTIONS, Section, page


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {
        "0001-one.md": "# 0001 One `wire`\n\nText.\n",
        "0002-two.md": "# 0002 Two\n\nSuperseded by 0003: all of it.\n",
        "0003-three.md": "# 0003 Three\n\nSuperseded by none.\n",
        "index.md": "# Decisions\n",
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def sections(*listed: str) -> list[Section]:
    return [Section(f"Subject {number}", "A sentence.", each) for number, each in enumerate(listed)]


def test_every_decision_is_a_line_of_the_index() -> None:
    """And every file of the folder is a decision, or the index itself."""
    lines = page().splitlines()
    names = {path.name for path in FOLDER.iterdir()} - {"index.md"}
    assert sum(any(f"]({name}) " in line for line in lines) for name in names) == len(names) > 300
    titles = [section.title for section in SECTIONS]
    assert [line.removeprefix("## ") for line in lines if line.startswith("## ")] == titles
    assert len(set(titles)) == len(titles)


def test_sections_have_a_length_that_can_be_looked_through() -> None:
    assert {section.title for section in SECTIONS if len(section.numbers) > 25} == set(), "divide them"


def test_a_section_lists_titles_in_its_own_order(folder: Path) -> None:
    text = page(folder, sections("0003 0001", "0002"))
    assert (
        "## Subject 0\n\nA sentence.\n\n- [0003](0003-three.md) Three\n- [0001](0001-one.md) One `wire`\n\n"
        "## Subject 1\n\nA sentence.\n\n- [0002](0002-two.md) Two (superseded by 0003)\n\n"
    ) in text


@pytest.mark.parametrize(
    ("listed", "told"),
    [
        (("0001", "0003"), "in no section: 0002"),
        (("0001 0002", "0003 0004"), "without a page: 0004"),
        (("0001 0002", "0002 0003"), "listed more than once: 0002"),
    ],
)
def test_a_decision_that_is_not_in_one_section_is_told(
    folder: Path, listed: tuple[str, ...], told: str
) -> None:
    with pytest.raises(ValueError, match=rf"{told}\..*docs/generate/decisions\.py"):
        page(folder, sections(*listed))


@pytest.mark.parametrize("heading", ["Four", "# Four", "# 0005 Four", "## 0004 Four", "# 0004"])
def test_a_first_line_of_another_form_is_told(folder: Path, heading: str) -> None:
    (folder / "0004-four.md").write_text(f"{heading}\n\nText.\n", encoding="utf-8")
    with pytest.raises(ValueError, match="0004-four"):
        page(folder, sections("0001 0002 0003 0004"))


def test_a_number_that_is_used_twice_is_told(folder: Path) -> None:
    (folder / "0003-tree.md").write_text("# 0003 Tree\n", encoding="utf-8")
    with pytest.raises(ValueError, match="have the number 0003"):
        page(folder, sections("0001 0002 0003"))
