"""Damaged, huge and malicious files of every kind end in an error of one line, never in a traceback."""

from __future__ import annotations

import random
from collections import Counter
from itertools import islice
from pathlib import Path

import pytest

from benchtool.errors import RecordingError, UsageError
from benchtool.plan import load_plan
from benchtool.recording import Bundle
from benchtool.recording.seal import read_sealed_json, write_json
from benchtool.tables import TableQuestion, analyze_table
from tests.fuzz.documents import Reader, rounds

ROUNDS = 40


def test_what_is_damaged_is_read_or_refused(tmp_path: Path) -> None:
    counts: Counter[str] = Counter()
    for _ in islice(rounds(tmp_path, random.Random(7), counts), ROUNDS):
        pass
    assert counts.total() == ROUNDS
    assert counts["profile refused"] > counts["profile read"]
    assert counts["bundle refused"] > 0


@pytest.mark.parametrize("name", ["/etc/passwd", "../outside", "a/../../b", "C:/x", "a\x00b", "x" * 500])
@pytest.mark.parametrize("table", ["streams", "files"])
def test_a_name_that_leads_out_of_a_bundle_is_refused(tmp_path: Path, table: str, name: str) -> None:
    Reader(tmp_path)
    manifest = tmp_path / "bundle" / "manifest.json"
    document, _ = read_sealed_json(manifest)
    document[table][name] = next(iter(document[table].values()))
    write_json(manifest, document, sealed=True)
    with pytest.raises(RecordingError, match=f"key '{table}': .*name"):
        Bundle.open(tmp_path / "bundle")


@pytest.mark.parametrize("number", ["9" * 200_000, "-" + "9" * 5_000, "0x" + "f" * 200_000, str(2**63)])
@pytest.mark.parametrize("key", ["settle_s", "title"])
def test_a_whole_number_of_too_many_digits_is_refused_in_a_line(
    tmp_path: Path, key: str, number: str
) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(f"{key} = {number}\n", encoding="utf-8")
    with pytest.raises(UsageError, match="a whole number has more digits than can be read") as refused:
        load_plan(str(plan))
    assert len(str(refused.value)) < 300


def test_a_table_of_many_empty_lines_takes_its_length_and_not_the_square(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    numbers = "".join(f"{n * 1e-4:.4f},{n % 7}\n" for n in range(40))
    table.write_text("1,2\n" + "\n" * 60_000 + numbers, encoding="utf-8")
    analyze_table(TableQuestion(file=table, time="1", columns={"current": "2"}))
