"""What is generated from the table: complete, stable, and the same thing to every reader."""

from __future__ import annotations

import copy
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import canopen
import pytest

from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.objects import DataType, table_from_toml
from firmware_protocol.generate import FOLDER, generated, main

DOCUMENT = tomllib.loads((FOLDER / "objects.toml").read_text(encoding="utf-8"))
TABLE = table_from_toml(DOCUMENT)
EDS = FOLDER / "drive.eds"
NODE_ID = 5


def test_generated_files_are_fresh(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check"]) == 0
    assert capsys.readouterr().err == ""


def test_check_names_each_stale_file_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([], folder=tmp_path) == 0
    (tmp_path / "drive.eds").write_text("old")
    (tmp_path / "objects.md").unlink()
    assert main(["--check"], folder=tmp_path) == 1
    errors = capsys.readouterr().err
    assert "drive.eds is stale" in errors
    assert "objects.md is stale" in errors
    assert "drive_objects.h" not in errors
    assert (tmp_path / "drive.eds").read_text() == "old"
    assert main([], folder=tmp_path) == 0
    assert main(["--check"], folder=tmp_path) == 0


def test_generation_depends_on_the_table_alone() -> None:
    reversed_document = {**DOCUMENT, "object": list(reversed(DOCUMENT["object"]))}
    assert generated(table_from_toml(reversed_document)) == generated(TABLE)
    assert not any(re.search(r"Date=|Time=|\b20\d\d-\d\d-\d\d", text) for text in generated(TABLE).values())


def test_eds_passes_the_checker_without_a_warning() -> None:
    checker = Path(sys.executable).with_name("dcfchk")
    run = subprocess.run(
        [checker, "-n", str(NODE_ID), EDS], capture_output=True, text=True, timeout=60, check=False
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_host_reads_from_the_eds_everything_the_table_says() -> None:
    dictionary = Dictionary.from_eds(EDS, NODE_ID)
    assert dictionary.warnings == ()
    assert dictionary.hash == TABLE.hash
    assert dictionary.identity.vendor_id == DOCUMENT["device"]["vendor_id"]
    assert dictionary.identity.product_code == DOCUMENT["device"]["product_code"]
    assert dictionary.identity.revision == DOCUMENT["device"]["revision"]
    assert [variable.key for variable in dictionary] == [(entry.index, entry.sub) for entry in TABLE]
    for entry, variable in zip(TABLE, dictionary, strict=True):
        default = TABLE.hash if entry.name == "dictionary_hash" else entry.default
        if entry.add_node_id:
            assert isinstance(default, int)
            default += NODE_ID
        for ours, theirs in (
            (variable.name, entry.name),
            (variable.type, entry.type),
            (variable.unit, entry.unit),
            (variable.factor, entry.factor),
            (variable.role, entry.role),
            (variable.access, entry.access),
            (variable.raw_minimum, entry.minimum),
            (variable.raw_maximum, entry.maximum),
            (variable.raw_default, default),
            (variable.values, entry.values),
            (variable.enabled_write, entry.enabled_write),
            (variable.description, entry.description),
            (variable.mappable, entry.mappable),
            (variable.mapping, entry.mapping),
        ):
            assert ours == theirs, entry.name


def test_canopen_reads_the_same_objects() -> None:
    theirs = canopen.import_od(str(EDS), node_id=NODE_ID)
    for entry in TABLE:
        found = theirs[entry.index]
        variable = found if isinstance(found, canopen.objectdictionary.ODVariable) else found[entry.sub]
        assert (variable.name, variable.data_type) == (entry.name, entry.type.code)
        assert variable.pdo_mappable is entry.mappable
        default = TABLE.hash if entry.name == "dictionary_hash" else entry.default
        if entry.type is not DataType.F32 and default is not None:
            offset = NODE_ID if entry.add_node_id else 0
            assert variable.default == (default if isinstance(default, str) else default + offset)
    assert theirs["motor.R_s"].index == 0x2000
    assert "2000sub2 Role=parameter Unit=ohm: Stator resistance per phase" in theirs.comments.splitlines()


def test_text_that_an_eds_would_cut_is_refused() -> None:
    first, *others = DOCUMENT["object"]
    table = table_from_toml({**DOCUMENT, "object": [{**first, "description": "this ; is lost"}, *others]})
    with pytest.raises(ValueError, match="would be cut"):
        generated(table)


def test_names_that_differ_only_in_case_are_refused() -> None:
    first, *others = DOCUMENT["object"]
    table = table_from_toml({**DOCUMENT, "object": [{**first, "name": "Torque"}, *others]})
    with pytest.raises(ValueError, match="BT_SUB_TORQUE"):
        generated(table)


def test_limits_by_entries_that_are_not_floats_are_refused() -> None:
    """The C library compares them as floats."""
    document = copy.deepcopy(DOCUMENT)
    entries = [entry for each in document["object"] for entry in each.get("entry", ())]
    (i_trip,) = [entry for entry in entries if entry["name"] == "i_trip"]
    i_trip["max_entry"] = "encoder_lines"
    with pytest.raises(ValueError, match=r"must be f32.*encoder_lines"):
        generated(table_from_toml(document))


def test_reference_page_has_a_row_of_eight_cells_for_every_entry() -> None:
    page = (FOLDER / "objects.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| 0x([0-9A-F]{4}):(\d+) (.*)$", page, flags=re.MULTILINE)
    assert [(int(index, 16), int(sub)) for index, sub, _ in rows] == list(TABLE.by_key)
    assert all(len(re.findall(r"(?<!\\)\|", cells)) == 8 for _, _, cells in rows)
    resistance = next(cells for index, sub, cells in rows if (index, sub) == ("2000", "2"))
    assert resistance == (
        "| `R_s` | f32 | ohm | 0 to 100 | 0.1 | rw | Parameter. Stator resistance per phase. |"
    )
    assert "| `producer_heartbeat` | u16 | s | 0 to 60 | 0.1 | rw |" in page


ROW = re.compile(
    r"X\(0x([0-9A-F]{4})u, (\d+)u, (\w+), (\w+), (\w+), (\w+), ([01]), ([01]), (.+?), (.+?), (.+)\) \\"
)

PROGRAM = r"""
#include <stdio.h>
#include "drive_objects.h"
#include "drive_objects.h"

struct entry { unsigned index, sub; const char *name; int type, access, role, enabled_write, add_node_id;
               double minimum, maximum; };

#define ROW(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, minimum, maximum, initial) \
    { index, sub, #name, BT_TYPE_##TYPE, BT_ACCESS_##ACCESS, BT_ROLE_##ROLE, enabled_write, add_node_id, \
      (double)(minimum), (double)(maximum) },
static const struct entry entries[] = { BT_ENTRIES(ROW) };

#define INITIAL(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, minimum, maximum, initial) \
    (void)(initial);

int main(void)
{
    unsigned n;
    BT_ENTRIES(INITIAL)
    for (n = 0; n < BT_ENTRY_COUNT; n++)
        printf("%u %u %s %d %.9g %.9g\n", entries[n].index, entries[n].sub, entries[n].name,
               entries[n].type, entries[n].minimum, entries[n].maximum);
    return sizeof entries / sizeof entries[0] == BT_ENTRY_COUNT && BT_LAW_TPC == 0 ? 0 : 1;
}
"""


def test_header_has_every_entry_and_compiles_where_a_compiler_is(tmp_path: Path) -> None:
    header = (FOLDER / "drive_objects.h").read_text(encoding="utf-8")
    assert f"#define BT_DICTIONARY_HASH 0x{TABLE.hash:08X}u" in header
    assert "#define BT_INDEX_MOTOR 0x2000u" in header
    assert "#define BT_SUB_R_S 2u" in header
    rows = ROW.findall(header)
    assert [(int(row[0], 16), int(row[1]), row[2]) for row in rows] == [
        (entry.index, entry.sub, entry.name) for entry in TABLE
    ]
    assert header.count("(") == header.count(")")
    if compiler := shutil.which("cc"):
        (tmp_path / "main.c").write_text(PROGRAM)
        flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", f"-I{FOLDER}"]
        program = tmp_path / "main"
        subprocess.run([compiler, *flags, "-o", program, tmp_path / "main.c"], check=True, timeout=60)
        listed = subprocess.run([program], capture_output=True, text=True, check=True, timeout=60).stdout
        for entry, line in zip(TABLE, listed.splitlines(), strict=True):
            index, sub, name, code, low, high = line.split()
            assert (int(index), int(sub), name) == (entry.index, entry.sub, entry.name)
            assert int(code) == entry.type.code
            assert entry.minimum is None or float(low) == pytest.approx(entry.minimum, rel=1e-6)
            assert entry.maximum is None or float(high) == pytest.approx(entry.maximum, rel=1e-6)
