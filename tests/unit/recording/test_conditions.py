"""What the operator states of a test, in the manifest and in the report."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from pydantic import ValidationError

from benchtool.cli.conditions import conditions
from benchtool.cli.run import RunOptions
from benchtool.cli.run_plans import _resumption
from benchtool.recording import Conditions, Manifest
from benchtool.recording.manifest import read_manifest, write_manifest
from benchtool.report.provenance import run_facts

STATED = Conditions(
    operator="A. Müller",
    test_object_serial_number="M-0017",
    temperature_degC=23.5,
    instruments=("torque transducer T40B 0815, cert. D-K-15070", "LEM IT 60-S"),
)
WHEN = "2026-01-01T00:00:00+00:00"


def test_conditions_are_kept_in_the_manifest_and_shown_in_the_report(tmp_path: Path) -> None:
    write_manifest(tmp_path, Manifest(what="test", when=WHEN, note="cold motor", conditions=STATED))
    manifest, sealed = read_manifest(tmp_path)
    assert sealed
    assert (manifest.conditions, manifest.note) == (STATED, "cold motor")
    facts = dict(run_facts(manifest).pairs)
    assert facts["operator"] == "A. Müller"
    assert facts["test object"] == "M-0017"
    assert facts["temperature"] == "23.5 °C"
    assert facts["instruments"] == "torque transducer T40B 0815, cert. D-K-15070; LEM IT 60-S"
    assert facts["note"] == "cold motor"


def test_what_is_not_stated_is_not_shown() -> None:
    facts = dict(run_facts(Manifest(what="test", when=WHEN)).pairs)
    assert not {"operator", "test object", "temperature", "instruments", "note"} & set(facts)


def test_a_manifest_of_an_earlier_version_has_none(tmp_path: Path) -> None:
    document = Manifest(what="test", when=WHEN).model_dump()
    del document["conditions"]
    assert Manifest.model_validate(document).conditions == Conditions()


def test_a_temperature_below_absolute_zero_is_refused() -> None:
    with pytest.raises(ValidationError):
        Conditions(temperature_degC=-300.0)


def test_a_run_that_goes_on_states_the_same() -> None:
    chosen = RunOptions(
        note="cold motor",
        operator=STATED.operator,
        serial_number=STATED.test_object_serial_number,
        temperature_degC=STATED.temperature_degC,
        instruments=STATED.instruments,
    )
    stated = (chosen.operator, chosen.serial_number, chosen.temperature_degC, chosen.instruments)
    assert conditions(*stated) == STATED
    words = shlex.split(_resumption("zhu2011/ripple", Path("runs/a"), chosen))
    assert words[words.index("--note") + 1] == "cold motor"
    assert words[words.index("--temperature") + 1] == "23.5"
    assert words.count("--instrument") == 2


def test_an_empty_text_states_no_instrument() -> None:
    assert conditions("", "", None, ["", " ", "scope 12"]).instruments == ("scope 12",)
