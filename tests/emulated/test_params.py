"""`benchtool params` from a user's point of view: output, writes, refusals."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app
from benchtool.drive import Identity, RemoteDrive
from benchtool.drive.parameters.migration import Migration, Migrations
from benchtool.errors import SdoAbort
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.dictionary.variable import Value
from benchtool.protocol.modes import Mode

Invoke = Callable[..., Result]


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(app, ("params", *arguments))


def _dumped(invoke: Invoke) -> str:
    assert invoke("dump", "a.toml").exit_code == 0
    return Path("a.toml").read_text(encoding="utf-8")


def _document(result: Result, code: int = 0) -> dict[str, Any]:
    assert result.exit_code == code, result.output
    document: dict[str, Any] = json.loads(result.stdout)
    return document


def _complaint(result: Result, code: int = 2) -> str:
    assert result.exit_code == code, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.output
    return result.stderr


def test_list_shows_value_default_and_limits(invoke: Invoke) -> None:
    document = _document(invoke("list", "?_TRIP", "--json"))
    listed = document["parameters"]
    assert [each["name"] for each in listed] == ["i_trip"]
    assert listed[0]["value"] == 12.0
    assert listed[0]["default"] == 10.0
    assert listed[0]["differs"] is True
    assert (listed[0]["minimum"], listed[0]["maximum"], listed[0]["unit"]) == (0.0, 10000.0, "A")
    text = invoke("list").stdout
    assert "* R_s                     0.123 ohm        default 0.1      0x2000:2 rw\n" in text
    assert "    Stator resistance per phase; 0 to 100 ohm\n" in text
    assert "  pole_pairs              4                default 4        0x2000:1 rw if off\n" in text
    assert "torque_command" not in text
    assert "no parameter matches 'zzz'" in _complaint(invoke("list", "zzz"))


def test_get_reads_by_name_key_and_index(invoke: Invoke) -> None:
    document = _document(invoke("get", "R_s", "psi_r_Wb", "0x2010:1", "--json"))
    assert document == {
        "R_s": {"value": 0.123, "unit": "ohm"},
        "psi_r": {"value": 0.1685, "unit": "Wb"},
        "law": {"value": "tpc", "unit": ""},
    }
    assert "R_s = 0.123 ohm\n" in invoke("get", "R_s").stdout
    assert "did you mean 'R_s'?" in _complaint(invoke("get", "R_S"))


def test_a_value_that_json_does_not_have_is_text(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RemoteDrive, "read", lambda drive, name: math.nan if name == "torque" else 0)
    monkeypatch.setattr(Identity, "require", lambda *_: None)
    assert _document(invoke("get", "torque", "--json")) == {"torque": {"value": "nan", "unit": "Nm"}}


def test_set_converts_units_and_reads_back(invoke: Invoke) -> None:
    document = _document(
        invoke("set", "R_s=246mohm", "L_d=9.6", "mH", "omega_observer_rad_s=3000rpm", "--json")
    )
    assert document == {
        "R_s": {"before": 0.123, "value": 0.246, "unit": "ohm"},
        "L_d": {"before": 0.00952, "value": 0.0096, "unit": "H"},
        "omega_observer": {"before": 160.0, "value": 314.15927, "unit": "rad/s"},
    }
    result = invoke("set", "encoder_offset=-5deg")
    assert "encoder_offset: 0 → -0.08726646 rad" in result.stdout
    assert "R_s: 0.123 → 0.2 ohm" in invoke("set", "R_s", "200", "mohm").stdout
    assert "delay_compensation: on → off" in invoke("set", "delay_compensation=off").stdout


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("R_s=5V",), "R_s = '5V': a value in ohm"),
        (("R_s=0.2", "u_s=5kV"), "its limits are 0 to 1000 V"),
        (("R_s",), "NAME=VALUE is expected"),
        (("R_s=",), "NAME=VALUE is expected"),
        (("=5",), "NAME=VALUE is expected"),
        (("R_s", "u_s=5"), "'R_s' stands before the first NAME=VALUE"),
        (("R_s=0.2", "R_s_ohm=0.3"), "'R_s' is given twice"),
        (("controlword=15",), "'controlword' (0x6040:0) is a status, a parameter is expected"),
        (("law=tcp",), "one of tpc"),
    ],
)
def test_mistakes_with_set(invoke: Invoke, arguments: tuple[str, ...], complaint: str) -> None:
    assert complaint in _complaint(invoke("set", *arguments))


def test_dump_is_deterministic_and_loads_without_a_change(invoke: Invoke) -> None:
    assert invoke("dump", "a.toml").exit_code == 0
    assert "a.toml exists" in _complaint(invoke("dump", "a.toml"))
    assert invoke("dump", "a.toml", "--force").exit_code == 0
    written = Path("a.toml").read_text(encoding="utf-8")
    printed = invoke("dump").stdout
    assert [line for line in printed.splitlines() if not line.startswith("date")] == [
        line for line in written.splitlines() if not line.startswith("date")
    ]
    content = tomllib.loads(written)
    assert content["parameters"]["psi_r_Wb"] == 0.1685
    assert content["drive"]["device_name"] == "benchtool reference drive"
    loaded = _document(invoke("load", "a.toml", "--json"))
    assert loaded == {"changed": {}, "loaded": len(content["parameters"]), "left_as_they_were": []}
    assert _document(invoke("diff", "a.toml", "--json"))["equal"] is True
    assert _document(invoke("dump", "--json")).keys() == {"drive", "parameters"}


def test_diff_and_load_of_a_changed_file(invoke: Invoke) -> None:
    text = _dumped(invoke)
    changed = text.replace("R_s_ohm = 0.123", "R_s_ohm = 0.2").replace("u_s_V = 81.65\n", "")
    Path("b.toml").write_text(changed, encoding="utf-8")
    found = _document(invoke("diff", "b.toml", "--json"), 1)
    assert found["differences"] == [
        {"key": "R_s_ohm", "a": 0.2, "b": 0.123},
        {"key": "u_s_V", "a": None, "b": 81.65},
    ]
    two = invoke("diff", "a.toml", "b.toml")
    assert two.exit_code == 1
    assert "differ in 2 keys" in two.stdout
    assert "missing" in two.stdout
    assert invoke("diff", "a.toml", "a.toml").exit_code == 0
    loaded = _document(invoke("load", "b.toml", "--json"))
    assert loaded["changed"] == {"R_s": {"before": 0.123, "value": 0.2}}
    assert loaded["left_as_they_were"] == ["u_s"]
    assert "left as they were: u_s" in invoke("load", "b.toml").stdout


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("R_s_ohm = 0.123", "R_s_mohm = 123"), "b.toml: no parameter 'R_s_mohm'"),
        (("R_s_ohm = 0.123", "R_s_ohm = 1e6"), "b.toml: R_s = 1000000 ohm: its limits are 0 to 100 ohm"),
        (("product_code = 0x", "product_code = 0x1"), "b.toml is of vendor"),
        (("dictionary_hash = 0x", "dictionary_hash = 0x1"), "key 'drive.dictionary_hash'"),
        (("[parameters]", "[parameter]"), "unknown key 'parameter': did you mean 'parameters'?"),
    ],
)
def test_mistakes_in_a_file(invoke: Invoke, change: tuple[str, str], complaint: str) -> None:
    text = _dumped(invoke)
    Path("b.toml").write_text(text.replace(*change), encoding="utf-8")
    assert complaint in _complaint(invoke("load", "b.toml"))


def test_a_file_of_an_old_dictionary(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    text = _dumped(invoke)
    hash_ = tomllib.loads(text)["drive"]["dictionary_hash"]
    old = text.replace(f"0x{hash_:08X}", "0x01D001D0").replace("R_s_ohm = 0.123", "R_s_mohm = 200")
    Path("old.toml").write_text(old, encoding="utf-8")
    refused = _complaint(invoke("load", "old.toml"))
    assert "dictionary 0x01D001D0" in refused
    assert "does not know R_s_mohm" in refused
    unlike = _document(invoke("diff", "old.toml", "--json"), 1)["differences"]
    assert [each["key"] for each in unlike] == ["drive.dictionary_hash", "R_s_mohm", "R_s_ohm"]

    rule = Migration(
        from_hash=0x01D001D0, to_hash=hash_, rename={"R_s_mohm": "R_s_ohm"}, scale={"R_s_ohm": 0.001}
    )
    rules = Migrations(migration=(rule,))
    monkeypatch.setattr("benchtool.cli.parameter_files.shipped_migrations", lambda: rules)
    loaded = _document(invoke("load", "old.toml", "--json"))
    assert loaded["changed"] == {"R_s": {"before": 0.123, "value": 0.2}}
    (difference,) = _document(invoke("diff", "old.toml", "--json"), 1)["differences"]
    assert difference == {"key": "R_s_ohm", "a": 0.2, "b": 0.123}


def test_load_refuses_an_enabled_drive(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    invoke("dump", "a.toml")
    identify = RemoteDrive.identify

    def enabled_by_another(drive: RemoteDrive) -> Identity:
        drive.enable(Mode.TORQUE)
        return identify(drive)

    monkeypatch.setattr(RemoteDrive, "identify", enabled_by_another)
    assert "'operation enabled', a file is loaded with the power stage off only" in _complaint(
        invoke("load", "a.toml")
    )


def test_a_load_that_fails_half_way_says_what_is_in_force(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = _dumped(invoke)
    changed = text.replace("R_s_ohm = 0.123", "R_s_ohm = 0.2").replace("u_s_V = 81.65", "u_s_V = 60.0")
    Path("b.toml").write_text(changed, encoding="utf-8")
    write, held = RemoteDrive.write, []

    def refusing(drive: RemoteDrive, name: str, value: Value) -> None:
        if name == "u_s" and value == 60.0:
            held.append(drive.read("R_s"))
            raise SdoAbort("writing 60.0 to 'u_s': refused", Abort.DEVICE_STATE)
        write(drive, name, value)
        held.append(drive.read("R_s"))

    monkeypatch.setattr(RemoteDrive, "write", refusing)
    complaint = _complaint(invoke("load", "b.toml"), 4)
    assert "refused" in complaint
    assert "the old values are in force again" in complaint
    assert held == [0.2, 0.2, 0.123]


def test_save_and_restore(invoke: Invoke) -> None:
    saved = _document(invoke("save", "--json"))
    assert saved["stored"] is True
    restored = _document(invoke("restore", "--json"))
    values = restored["parameters"]
    assert values["R_s"] == 0.1
    result = invoke("save")
    assert "parameters stored" in result.stdout
    assert "lives as long as its command" in result.stderr


def test_a_drive_that_does_not_answer(invoke: Invoke) -> None:
    assert "node 9 did not answer" in _complaint(invoke("list", "--link", "emulated?node=9"), 3)
