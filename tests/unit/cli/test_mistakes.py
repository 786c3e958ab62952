"""Mistakes at the command line: all of a kind are told at once, with exit code 2, before anything is done."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app

TABLE = "t [s],T [Nm],i [A]\n" + "".join(f"{row},{row % 3},{row % 5}\n" for row in range(40))


def told(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--time", "1:kg", "--torque", "2:V", "--current", "3:B"), ("'kg'", "'V'", "'B'")),
        (("--time", "1", "--torque", "foo", "--current", "bar"), ("'foo'", "'bar'")),
        (("--time", "9", "--torque", "2:V"), ("no column '9'", "'V' is no unit")),
    ],
)
def test_every_column_that_is_wrong_is_told(
    tmp_path: Path, arguments: tuple[str, ...], expected: tuple[str, ...]
) -> None:
    """One of them was told, and the next once that was mended."""
    (tmp_path / "table.csv").write_text(TABLE, encoding="utf-8")
    refused = told("analyze", "--csv", str(tmp_path / "table.csv"), *arguments)
    assert refused.exit_code == 2
    lines = refused.stderr.splitlines()
    assert len(lines) == len(expected)
    assert all(any(each in line for line in lines) for each in expected)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("params", "get", "foo", "bar"), ("no object 'foo'", "no object 'bar'")),
        (("params", "set", "foo=1", "L_d=x"), ("no object 'foo'", "L_d = 'x'")),
        (("params", "set", "R_s=-1", "L_d=-1", "foo=3"), ("R_s = -1", "L_d = -1", "no object 'foo'")),
        (("commission", "foo", "bar", "--dry-run"), ("no step 'foo'", "no step 'bar'")),
        (("record", "--channels", "foo,bar", "--duration", "0.2"), ("no object 'foo'", "no object 'bar'")),
        (("compare", "foo", "bar"), ("foo does not exist", "bar does not exist")),
    ],
)
def test_every_name_that_is_wrong_is_told(arguments: tuple[str, ...], expected: tuple[str, ...]) -> None:
    refused = told(*arguments)
    assert refused.exit_code == 2
    assert refused.stdout == ""
    for each in expected:
        assert sum(each in line for line in refused.stderr.splitlines()) == 1


@pytest.mark.parametrize("content", [b"", b"\0\0\0\0", bytes(range(256)) * 8, b"no numbers here\n" * 3])
@pytest.mark.parametrize("verb", [["gauge"], ["analyze", "--time", "1", "--torque", "2", "--csv"]])
def test_what_is_no_table_is_a_mistake_of_usage(tmp_path: Path, verb: list[str], content: bytes) -> None:
    """The exit code was 3, as of a computer that lacks something."""
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    for each in (path, tmp_path, tmp_path / "none.csv"):
        refused = told(*verb, str(each))
        assert refused.exit_code == 2
        assert len(refused.stderr.splitlines()) == 1


def test_what_is_no_dictionary_is_a_mistake_of_usage(tmp_path: Path) -> None:
    (tmp_path / "x.eds").write_bytes(b"\x7fELF\x02")
    for path in (tmp_path / "x.eds", tmp_path, tmp_path / "none.eds"):
        assert told("info", "--eds", str(path)).exit_code == 2


def test_files_that_cannot_be_written_are_told_before_a_plan_is_run(tmp_path: Path) -> None:
    """The plan was run to its end, and then the document could not be written."""
    refused = told("run", "zhu2011/ripple", "--junit", str(tmp_path), "--out", str(tmp_path / "run"))
    assert refused.stderr == f"benchtool: {tmp_path} is a folder: name a file\n"
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("verb", [["verify"], ["run", "zhu2011/ripple", "--resume"]])
def test_a_file_in_place_of_a_run_is_named_as_it_was_given(tmp_path: Path, verb: list[str]) -> None:
    """It was said not to exist, or the folder above it was named."""
    path = tmp_path / "a" / "notes.txt"
    path.parent.mkdir()
    path.write_text("notes", encoding="utf-8")
    refused = told(*verb, str(path))
    assert refused.exit_code == 2
    assert str(path) in refused.stderr
    assert "does not exist" not in refused.stderr
