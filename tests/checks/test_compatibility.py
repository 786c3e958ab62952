"""What the last version promised holds, or the version that goes with it has stepped; breaks are seen."""

from __future__ import annotations

import re
import tomllib

import pytest
from pydantic import BaseModel, create_model

from benchtool.protocol.dictionary.objects import ObjectTable, table_from_toml
from benchtool.protocol.serial.messages import VERSION
from benchtool.recording.manifest import SCHEMA_VERSION, Manifest
from docs.generate.json_documents import DOCUMENTS, Reset
from firmware_protocol import vectors
from tests.compatibility.promises import (
    PROMISES,
    ROOT,
    breaks,
    bundle,
    dictionary,
    json_documents,
    promised,
    serial,
    unannounced,
)

OBJECTS = (ROOT / "firmware_protocol" / "objects.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PROMISES)
def test_what_was_promised_holds(name: str) -> None:
    found = unannounced(promised(name), PROMISES[name]())
    assert found == [], "step its version (CONTRIBUTING.md, Compatibility); at a release renew the snapshot"


def _table(old: str, new: str, revision: str = "0x00010001") -> ObjectTable:
    assert OBJECTS.count(old) >= 1
    text = re.sub(r"(?m)^revision = .*$", f"revision = {revision}", OBJECTS.replace(old, new, 1))
    return table_from_toml(tomllib.loads(text))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name = "psi_r"', 'name = "psi_m"', "name was 'psi_r'"),
        ('name = "T_k_ratio"\n  type = "f32"', 'name = "T_k_ratio"\n  type = "u16"', "type was 'f32'"),
        ("index = 0x2030", "index = 0x2FF0", "0x2030:1 is gone"),
    ],
)
def test_a_break_of_the_dictionary_needs_a_revision(old: str, new: str, said: str) -> None:
    then = dictionary(_table(old, old))
    assert any(said in each for each in unannounced(then, dictionary(_table(old, new))))
    assert unannounced(then, dictionary(_table(old, new, "0x00020000"))) == []


def test_limits_may_widen_and_not_narrow() -> None:
    then = dictionary()
    name, properties = next((k, v) for k, v in then.facts.items() if v["max"] is not None and v["max"] > 1)
    for factor, count in ((2.0, 0), (0.5, 1)):
        altered = {**then.facts, name: {**properties, "max": properties["max"] * factor}}
        assert len(breaks(then, type(then)(then.version, altered))) == count


def test_a_break_of_the_json_needs_a_minor_version() -> None:
    class Shorter(BaseModel):
        before: str
        error_code: str | None

    class Other(Shorter):
        after: int

    then = json_documents(version="0.1.0")
    for model, said in ((Shorter, "reset: after is gone"), (Other, "reset: after: kind was 'text'")):
        altered = {**DOCUMENTS, "reset": model}
        assert any(said in each for each in unannounced(then, json_documents(altered, "0.1.3")))
        assert unannounced(then, json_documents(altered, "0.2.0")) == []
        assert unannounced(json_documents(version="1.4.0"), json_documents(altered, "1.5.0"))
    longer = create_model("Longer", __base__=Reset, more=(int, ...))
    assert unannounced(then, json_documents({**DOCUMENTS, "reset": longer}, "0.1.1")) == []


def test_a_break_of_the_bundle_needs_a_schema_version() -> None:
    needy = create_model("Needy", __base__=Manifest, more=(int, ...))
    optional = create_model("Optional", __base__=Manifest, more=(int, 1))
    other = create_model("Other", __base__=Manifest, seed=(str, ""))
    assert unannounced(bundle(), bundle(optional)) == []
    for model, said in ((needy, "manifest: more is new and required"), (other, "manifest: seed: kind")):
        assert any(said in each for each in unannounced(bundle(), bundle(model)))
        assert unannounced(bundle(), bundle(model, SCHEMA_VERSION + 1)) == []
    assert any("manifest: what is gone" in each for each in unannounced(bundle(), bundle(Reset)))


def test_a_break_of_the_serial_protocol_needs_a_version() -> None:
    golden = vectors.render()
    altered = golden.replace('"frame": "0005020941', '"frame": "0005020942', 1)
    assert altered != golden
    assert unannounced(serial(), serial(altered)) == [
        next(each for each in breaks(serial(), serial(altered)) if each.startswith("message read"))
    ]
    assert unannounced(serial(), serial(altered, VERSION + 1)) == []
