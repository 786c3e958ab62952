"""A file of another kind than is expected is told as what it is."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.acceptance.waivers import load_waivers
from benchtool.cli import app
from benchtool.drive.parameters.file import read_parameter_file
from benchtool.errors import UsageError
from benchtool.file_kinds import FileKind, kind_of
from benchtool.plan import load_plan, plan_names
from benchtool.profile import load_bench, load_profile
from benchtool.shipped import shipped

TEXTS = {
    FileKind.PLAN: 'title = "t"\nprofile = "zhu2011"\n[record]\nduration_s = 1.0\n',
    FileKind.PROFILE: 'title = "t"\n[motor]\npole_pairs = 4\n[limits]\ntorque_Nm = 1.0\n',
    FileKind.BENCH: "[bench.channels.i_a]\ngain_U_percent = 0.2\n",
    FileKind.PARAMETERS: "[drive]\nvendor_id = 1\n[parameters]\nu_s_V = 1.0\n[profile]\nfile = 3\n",
    FileKind.WAIVERS: '[[waiver]]\ntest = "x"\n',
    FileKind.EDS: (shipped("firmware_protocol") / "drive.eds").read_text(encoding="utf-8"),
    FileKind.MANIFEST: '{"what": "a run", "when": "2026-01-01T00:00:00+00:00"}\n',
}
READERS: dict[FileKind, Callable[[Path], object]] = {
    FileKind.PLAN: lambda path: load_plan(str(path)),
    FileKind.PROFILE: lambda path: load_profile(str(path)),
    FileKind.BENCH: lambda path: load_bench(str(path)),
    FileKind.PARAMETERS: read_parameter_file,
    FileKind.WAIVERS: load_waivers,
}


def _file(folder: Path, kind: FileKind, suffix: str = ".toml") -> Path:
    path = folder / f"given{suffix}"
    path.write_text(TEXTS[kind], encoding="utf-8")
    return path


@pytest.mark.parametrize("given", TEXTS)
@pytest.mark.parametrize("expected", READERS)
def test_one_sentence_says_what_it_is_and_what_to_do(
    tmp_path: Path, given: FileKind, expected: FileKind
) -> None:
    """A profile in place of a plan had four unknown keys."""
    path = _file(tmp_path, given)
    assert kind_of(path) is given
    if given is expected or (given, expected) == (FileKind.PROFILE, FileKind.BENCH):  # which has a bench
        return
    with pytest.raises(UsageError) as refused:
        READERS[expected](path)
    assert str(refused.value).startswith(f"{path} is a {given}, and a {expected} is expected: ")
    assert getattr(refused.value, "__notes__", []) == []


@pytest.mark.parametrize("given", [FileKind.EDS, FileKind.MANIFEST])
@pytest.mark.parametrize("expected", [FileKind.PLAN, FileKind.PROFILE])
def test_so_does_one_with_its_own_suffix(tmp_path: Path, given: FileKind, expected: FileKind) -> None:
    path = _file(tmp_path, given, ".eds" if given is FileKind.EDS else ".json")
    with pytest.raises(UsageError, match=rf"is a .*, and a {expected} is expected: "):
        READERS[expected](path)


@pytest.mark.parametrize("place", ["", "case"])
def test_a_recorded_run_is_no_folder_of_plans(tmp_path: Path, place: str) -> None:
    (tmp_path / place).mkdir(exist_ok=True)
    (tmp_path / place / "manifest.json").write_text("{}", encoding="utf-8")
    for read in (lambda: plan_names(str(tmp_path)), lambda: load_profile(str(tmp_path))):
        with pytest.raises(UsageError, match="is a folder of a recorded run, and a p"):
            read()


def test_a_misspelt_key_makes_no_other_kind(tmp_path: Path) -> None:
    """It may be a table of another kind: what is wrong with the rest is told then."""
    path = _file(tmp_path, FileKind.PLAN)
    path.write_text(f"{TEXTS[FileKind.PLAN]}[motor]\npole_pairs = 4\n", encoding="utf-8")
    assert kind_of(path) is None
    with pytest.raises(UsageError, match="unknown key 'motor'"):
        load_plan(str(path))
    assert kind_of(tmp_path / "none") is None
    assert kind_of(tmp_path / ("long" * 100)) is None
    assert kind_of(tmp_path) is None


@pytest.mark.parametrize("given", [FileKind.PLAN, FileKind.PROFILE, FileKind.EDS, FileKind.MANIFEST])
@pytest.mark.parametrize("verb", [["gauge"], ["analyze", "--time", "1", "--torque", "2", "--csv"]])
def test_a_file_in_place_of_a_table_is_told_as_what_it_is(
    tmp_path: Path, verb: list[str], given: FileKind
) -> None:
    """Its first line was said to have another number of cells than its head."""
    path = _file(tmp_path, given)
    told = CliRunner().invoke(app, [*verb, str(path)])
    assert told.exit_code == 2
    assert f"{path} is a {given}, and a table of numbers is expected: " in told.stderr


@pytest.mark.parametrize("given", [FileKind.PLAN, FileKind.PROFILE])
def test_a_file_in_place_of_an_eds_is_told_as_what_it_is(tmp_path: Path, given: FileKind) -> None:
    path = _file(tmp_path, given)
    told = CliRunner().invoke(app, ["info", "--eds", str(path)])
    assert told.exit_code == 2
    assert f"{path} is a {given}, and a dictionary (EDS) is expected: " in told.stderr


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert kind_of(tmp_path / "pipe") is None


@pytest.mark.parametrize("given", [FileKind.PLAN, FileKind.PROFILE, FileKind.EDS, FileKind.MANIFEST])
@pytest.mark.parametrize("verb", ["analyze", "report", "export", "verify"])
def test_a_file_in_place_of_a_run_is_told_as_what_it_is(tmp_path: Path, verb: str, given: FileKind) -> None:
    """A plan was called a table of another tool."""
    path = _file(tmp_path, given)
    told = CliRunner().invoke(app, [verb, str(path)])
    assert told.exit_code in (2, 3)
    assert f"{path} is a {given}, and a folder of a recorded run is expected: " in told.stderr


@pytest.mark.parametrize(
    "rows", ["t,x\n0,1\n1e-3,-2.5\n", "Zeit;Strom\n0,0;1,5\n0,1;-2,5\n", "# x\n1\t2\n3\t4"]
)
@pytest.mark.parametrize(("verb", "wanted"), [("run", "plan"), ("analyze", "folder of a recorded run")])
def test_a_table_in_place_of_another_file_is_told_as_one(
    tmp_path: Path, verb: str, wanted: str, rows: str
) -> None:
    path = tmp_path / "bench.csv"
    path.write_text(rows, encoding="utf-8")
    told = CliRunner().invoke(app, [verb, str(path)])
    assert told.exit_code == 2
    assert f"a {wanted} is expected: measure its columns with 'benchtool analyze --csv {path}'" in told.stderr


@pytest.mark.parametrize("text", ["x = 1\n= 2\n", "1, 2\n", "a,b\nc,d\n", "[motor\n1,2\n", ""])
def test_a_text_without_rows_of_numbers_is_no_table(tmp_path: Path, text: str) -> None:
    path = tmp_path / "other.txt"
    path.write_text(text, encoding="utf-8")
    assert kind_of(path) is None


def test_empty_lines_take_their_number_and_not_its_square(tmp_path: Path) -> None:
    def least_s(lines: int) -> float:
        path = tmp_path / "table.csv"
        path.write_text("\n" * lines + "1,2\n3,4\n", encoding="utf-8")
        taken = []
        for _ in range(3):
            begun = time.perf_counter()
            assert kind_of(path) is FileKind.TABLE
            taken.append(time.perf_counter() - begun)
        return min(taken)

    assert least_s(1 << 16) < 100.0 * least_s(1 << 12)  # 16 times as many; the square is 256 times as much
