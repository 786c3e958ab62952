"""A short run of the fuzzer, the same every time; `python -m tests.fuzz.serial` runs longer ones."""

from __future__ import annotations

import json

import pytest

from tests.fuzz.serial import fuzz, main


def test_no_round_fails_and_every_kind_of_damage_is_met() -> None:
    met = fuzz(0, rounds=400)
    assert met["rounds"] == 400
    for kind in (
        *("frames", "too_long", "bad_stuffing", "too_short", "bad_crc", "frames_lost"),
        *("understood", "not_understood", "rejected", "rows", "rows_missing", "rows_refused"),
        *("damage_bits", "damage_cut", "damage_noise", "damage_swap", "damage_insert", "damage_join"),
    ):
        assert met[kind] > 10, kind


def test_a_line_without_a_checksum_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("zlib.crc32", lambda _: 0)
    with pytest.raises(AssertionError, match="seed 0, round"):
        fuzz(0, rounds=400)


def test_the_command_reports_what_it_met(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--seconds", "0.05", "--seed", "3", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["seed"] == 3
    assert report["rounds"] > 0
