"""Parameter files: written and read back; entries that do not fit a drive are refused by name."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from benchtool.drive.identity import Identity
from benchtool.drive.parameters.file import (
    ParameterFile,
    Provenance,
    describe,
    read_parameter_file,
    render,
    write_parameter_file,
)
from benchtool.drive.parameters.migration import Migration, Migrations
from benchtool.drive.parameters.settings import aligned, as_held, compare, is_address, settings
from benchtool.drive.parameters.transaction import default_of, parameters
from benchtool.errors import ParameterFileError, RecordingError, ValueRefused
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.keys import toml_key
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Value, Variable
from benchtool.shipped import shipped

DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
HASH = DICTIONARY.hash or 0
IDENTITY = Identity(
    DICTIONARY.identity.vendor_id or 0,
    DICTIONARY.identity.product_code or 0,
    0x10000,
    7,
    "drive",
    "A",
    "0.1.0",
    HASH,
)
OLD = 0x01D0_01D0
# The invented old version: resistance in mohm, and a parameter that is no more.
RULES = Migrations(
    migration=(
        Migration(
            from_hash=OLD,
            to_hash=HASH,
            rename={"R_s_mohm": "R_s_ohm"},
            scale={"R_s_ohm": 0.001},
            drop=("filter_Hz",),
        ),
    )
)


def _file(
    values: dict[str, int | float | str],
    *,
    hash_: int | None = HASH,
    vendor_id: int | None = IDENTITY.vendor_id,
    product_code: int | None = IDENTITY.product_code,
    serial_number: int | None = None,
) -> ParameterFile:
    provenance = Provenance(
        dictionary_hash=hash_, vendor_id=vendor_id, product_code=product_code, serial_number=serial_number
    )
    return ParameterFile(drive=provenance, parameters=values)


def _settings(file: ParameterFile, rules: Migrations | None = None) -> dict[str, Value]:
    return settings(file, "mine.toml", DICTIONARY, IDENTITY, rules or Migrations())


def _refusal(file: ParameterFile, rules: Migrations | None = None) -> str:
    with pytest.raises(ParameterFileError) as refused:
        _settings(file, rules)
    message = str(refused.value)
    assert message.startswith("mine.toml")
    assert "\n" not in message
    return message


def _defaults() -> dict[str, int | float | str]:
    values = {toml_key(variable): default_of(variable) for variable in parameters(DICTIONARY)}
    return {key: value for key, value in values.items() if isinstance(value, int | float | str)}


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    file = describe(IDENTITY, _defaults(), "2026-11-21T12:00:00+01:00")
    text = render(file, DICTIONARY)
    write_parameter_file(tmp_path / "a.toml", text)
    assert read_parameter_file(tmp_path / "a.toml") == file
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


def test_the_text_is_for_people_and_always_the_same() -> None:
    file = describe(IDENTITY, {"R_s_ohm": 0.123, "law": "tpc", "mystery": 1}, "2026-11-21")
    text = render(file, DICTIONARY)
    assert f"dictionary_hash = 0x{HASH:08X}\n" in text
    assert "# Stator resistance per phase; 0 to 100 ohm\nR_s_ohm = 0.123\n" in text
    assert "; one of tpc" in text
    assert "\n\nmystery = 1\n" in text
    assert text == render(file, DICTIONARY)


@given(
    st.dictionaries(
        st.text(min_size=1, max_size=8),
        st.integers(-(2**63), 2**63 - 1)
        | st.floats(allow_nan=False, allow_infinity=False)
        | st.text(max_size=8),
        max_size=4,
    ),
    st.text(max_size=8),
)
def test_any_names_and_values_survive_the_file(values: dict[str, int | float | str], name: str) -> None:
    file = describe(replace(IDENTITY, device_name=name), values, "now")
    assert ParameterFile.model_validate(tomllib.loads(render(file, DICTIONARY))) == file


def test_what_is_no_number_on_the_drive_is_not_written_to_a_file() -> None:
    with pytest.raises(ParameterFileError, match="the drive holds 'R_s_ohm' = nan"):
        describe(IDENTITY, {"R_s_ohm": math.nan}, "now")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[parameters", "not TOML"),
        ("[parameters]\n", "key 'drive' is missing"),
        ("[drive]\nvendor_id = 1\nproduct_code = 2\n", "key 'parameters' is missing"),
        ("[drive]\nvendor_id = 1\nproduct_cod = 2\n[parameters]\n", "did you mean 'product_code'?"),
        ("[drive]\nvendor_id = 1\nproduct_code = 2\ndictionary_hash = -1\n[parameters]\n", "dictionary_hash"),
        ("[drive]\nvendor_id = 1\nproduct_code = 2\n[parameters]\nR_s_ohm = true\n", "R_s_ohm"),
        ("[drive]\nvendor_id = 1\nproduct_code = 2\n[parameters]\nR_s_ohm = [1]\n", "R_s_ohm"),
        ("[drive]\nvendor_id = 1\nproduct_code = 2\n[parameters]\nR_s_ohm = nan\n", "R_s_ohm"),
    ],
)
def test_a_file_of_another_form_is_refused(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ParameterFileError) as refused:
        read_parameter_file(path)
    assert complaint in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_cannot_be_read_or_written(tmp_path: Path) -> None:
    with pytest.raises(ParameterFileError, match="cannot read"):
        read_parameter_file(tmp_path / "none.toml")
    with pytest.raises(RecordingError, match="cannot write"):
        write_parameter_file(tmp_path / "no" / "folder.toml", "")


def test_settings_are_by_name_in_the_dictionarys_order() -> None:
    found = _settings(_file({"u_s_V": 80, "law": "tpc", "R_s_ohm": 0.2}))
    assert list(found.items()) == [("R_s", 0.2), ("law", "tpc"), ("u_s", 80)]


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"R_s_mohm": 123.0}, "no parameter 'R_s_mohm'"),
        ({"R_s": 0.123}, "write 'R_s_ohm'"),
        ({"R_s_ohm": 1e6}, "its limits are 0 to 100 ohm"),
        ({"pole_pairs": 4.5}, "a whole number is expected"),
        ({"law": "tcp"}, "one of"),
        ({"torque_command_Nm": 1.0}, "is a command with access 'rw', a writable parameter is expected"),
        ({"controlword": 15}, "a writable parameter is expected"),
    ],
)
def test_a_key_or_value_that_does_not_fit_is_named(
    values: dict[str, int | float | str], complaint: str
) -> None:
    assert complaint in _refusal(_file(values))


def test_another_product_is_refused_and_another_serial_number_is_not() -> None:
    message = _refusal(_file({}, product_code=0x99))
    assert "product 0x00000099" in message
    assert f"product 0x{IDENTITY.product_code:08X}" in message
    assert _settings(_file({"R_s_ohm": 0.2}, serial_number=123)) == {"R_s": 0.2}


def test_another_vendor_with_the_same_product_code_is_refused() -> None:
    other = (IDENTITY.vendor_id or 0) + 1
    message = _refusal(_file({}, vendor_id=other))
    assert f"vendor 0x{other:08X}" in message
    assert f"vendor 0x{IDENTITY.vendor_id:08X}" in message


def test_a_file_of_an_old_dictionary_is_migrated() -> None:
    old = _file({"R_s_mohm": 123, "filter_Hz": 50.0, "law": "tpc"}, hash_=OLD)
    assert _settings(old, RULES) == {"R_s": 0.123, "law": "tpc"}


def test_what_is_migrated_is_still_checked() -> None:
    assert "its limits are 0 to 100 ohm" in _refusal(_file({"R_s_mohm": 1e9}, hash_=OLD), RULES)
    assert "'R_s_ohm' is 'low'" in _refusal(_file({"R_s_mohm": "low"}, hash_=OLD), RULES)


def test_without_a_rule_an_old_file_is_refused_by_name() -> None:
    message = _refusal(_file({"R_s_mohm": 123, "filter_Hz": 50.0, "law": "tpc"}, hash_=OLD))
    assert "dictionary 0x01D001D0" in message
    assert f"speaks 0x{HASH:08X}" in message
    assert "does not know R_s_mohm, filter_Hz:" in message
    assert "dictionary_hash" in message
    assert "it knows every key" in _refusal(_file({"law": "tpc"}, hash_=OLD))


def test_node_id_and_bit_rate_are_left_alone_unless_asked_for() -> None:
    address = Variable(0x100B, 0, "address", DataType.U8, role="parameter")
    node_id = Variable(0x2F00, 1, "node_id", DataType.U8, role="parameter")
    rate = Variable(0x2F00, 2, "bit_rate", DataType.U32, role="parameter")
    assert all(is_address(each) for each in (address, node_id, rate))
    assert not any(is_address(each) for each in DICTIONARY)
    extended = replace(DICTIONARY, variables={**DICTIONARY.variables, "node_id": node_id, "bit_rate": rate})
    file = _file({"node_id": 9, "bit_rate": 125000, "R_s_ohm": 0.2})
    assert settings(file, "f", extended, IDENTITY, RULES) == {"R_s": 0.2}
    everything = settings(file, "f", extended, IDENTITY, RULES, with_address=True)
    assert everything == {"R_s": 0.2, "node_id": 9, "bit_rate": 125000}


def test_differences_are_named_with_both_sides() -> None:
    a, b = _file({"R_s_ohm": 0.1, "u_s_V": 80, "law": "tpc"}), _file({"R_s_ohm": 0.2, "law": "tpc", "x": 1})
    assert [(each.key, each.a, each.b) for each in compare(a, b)] == [
        ("R_s_ohm", 0.1, 0.2),
        ("u_s_V", 80, None),
        ("x", None, 1),
    ]
    assert compare(a, a) == ()


def test_another_dictionary_or_product_is_a_difference_and_a_date_is_not() -> None:
    (difference,) = compare(_file({}), _file({}, hash_=OLD))
    assert (difference.key, difference.b) == ("drive.dictionary_hash", "0x01D001D0")
    (difference,) = compare(_file({}), _file({}, vendor_id=1))
    assert difference.key == "drive.vendor_id"
    assert compare(describe(IDENTITY, {}, "monday"), describe(IDENTITY, {}, "sunday")) == ()


def test_an_old_file_is_compared_by_todays_keys_on_either_side() -> None:
    old, new = _file({"R_s_mohm": 200}, hash_=OLD), _file({"R_s_ohm": 0.2})
    for a, b in ((old, new), (new, old)):
        assert compare(*aligned(a, b, RULES)) == ()
        assert len(compare(*aligned(a, b, Migrations()))) == 3


def test_values_are_compared_as_the_drive_holds_them() -> None:
    typed = _file(
        {"R_s_ohm": 0.1230000000001, "law": 0, "producer_heartbeat_s": 0.1004, "u_s_V": 1e9, "x": 1}
    )
    assert as_held(typed, DICTIONARY).parameters == {
        "R_s_ohm": 0.123,
        "law": "tpc",
        "producer_heartbeat_s": 0.1,
        "u_s_V": 1e9,
        "x": 1,
    }


def test_a_dictionary_without_parameters_is_named() -> None:
    bare = replace(DICTIONARY, variables={"statusword": DICTIONARY["statusword"]})
    with pytest.raises(ValueRefused, match=r"drive\.eds names no parameters"):
        parameters(bare)
