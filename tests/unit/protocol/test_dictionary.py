"""Dictionaries from third-party files: oddities are tolerated or named."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import DictionaryError, ValueRefused
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.objects import DataType
from benchtool.shipped import shipped

VENDOR = """\
; a file that no checker has seen
[FileInfo]
FileVersion=002
[deviceinfo]
vendorname=Grün & Söhne
VendorNumber=0x9A
ProductName=Servo µ
ProductNumber=none
[OptionalObjects]
SupportedObjects=1
1=0x2FFF
[1000]
ParameterName=Device Type
ObjectType=0x7
DataType=0x0007
AccessType=RO
DefaultValue=0x00020192   ; inline comment
PDOMapping=0
[1014]
ParameterName=COB-ID EMCY
DataType=7
AccessType=rw
DefaultValue=$NodeID+0x80
[1018]
ParameterName=Identity
ObjectType=9
SubNumber=2
[1018sub0]
ParameterName=Entries
DataType=5
AccessType=const
DefaultValue=1
[1018Sub1]
ParameterName=Vendor ID
DataType=7
AccessType=ro
[2000]
ParameterName=Gains
ObjectType=0x8
SubNumber=3
[2000sub0]
ParameterName=Entries
DataType=5
AccessType=const
[2000sub1]
ParameterName=Gain
DataType=0x0008
AccessType=rww
LowLimit=0x3F000000
HighLimit=2.5
DefaultValue=1
Unit=Nm
Factor=0.5
[2000subA]
ParameterName=Gain
DataType=8
AccessType=rwr
DefaultValue=nan
[2001]
ParameterName=Offset
DataType=4
AccessType=rw
LowLimit=0xFFFFFFF6
HighLimit=0x7FFFFFFF
DefaultValue=-5
[2002]
ParameterName=Odd type
DataType=0x0016
AccessType=rw
[2003]
DataType=6
AccessType=sometimes
LowLimit=9
HighLimit=3
DefaultValue=70000
[2004]
ParameterName=Flag
DataType=1
AccessType=rw
[2005]
ParameterName=Position
DataType=0x1B
AccessType=ro
[2006]
ParameterName=Wrapped
DataType=0xA0
AccessType=rw
[A0sub1]
ParameterName=type
DefaultValue=0x06
[2007]
ParameterName=List
ObjectType=8
DataType=6
AccessType=rw
CompactSubObj=3
[2007Name]
NrOfEntries=1
2=Middle
[2008]
ParameterName=Program
ObjectType=2
AccessType=wo
[2009]
ParameterName=Hollow
ObjectType=9
[200Asub1]
ParameterName=Orphan
DataType=6
AccessType=rw
this line means nothing
[2001]
Unit=rad
"""


@pytest.fixture
def vendor() -> Dictionary:
    return Dictionary.from_bytes(VENDOR.encode("cp1252"), 5, "vendor.eds")


def test_identity(vendor: Dictionary) -> None:
    assert vendor.identity.vendor_name == "Grün & Söhne"
    assert vendor.identity.product_name == "Servo µ"
    assert (vendor.identity.vendor_id, vendor.identity.product_code) == (0x9A, None)
    assert vendor.identity.revision is None
    assert vendor.hash is None


def test_names_are_unique_and_say_whose_they_are(vendor: Dictionary) -> None:
    assert list(vendor.variables) == [
        "Device Type",
        "COB-ID EMCY",
        "Identity.Entries",
        "Vendor ID",
        "Gains.Entries",
        "Gains.Gain 0x2000:1",
        "Gains.Gain 0x2000:10",
        "Offset",
        "Odd type",
        "0x2003:0",
        "Flag",
        "Position",
        "Wrapped",
        "NrOfObjects",
        "List1",
        "Middle",
        "List3",
        "Program",
        "Orphan",
    ]
    assert len(vendor) == 19
    assert [variable.name for variable in vendor] == list(vendor.variables)


def test_numbers(vendor: Dictionary) -> None:
    assert vendor["Device Type"].raw_default == 0x20192
    assert vendor["COB-ID EMCY"].raw_default == 0x85
    gain = vendor["0x2000:1"]
    assert (gain.raw_minimum, gain.raw_maximum, gain.raw_default) == (0.5, 2.5, 1.0)
    assert (gain.minimum, gain.maximum, gain.default, gain.unit) == (0.25, 1.25, 0.5, "Nm")
    offset = vendor["Offset"]
    assert (offset.raw_minimum, offset.raw_maximum, offset.raw_default) == (-10, 0x7FFFFFFF, -5)
    assert offset.unit == "rad"


def test_types(vendor: Dictionary) -> None:
    assert vendor["Odd type"].type is DataType.DOMAIN
    assert vendor["Flag"].type is DataType.U8
    assert vendor["Position"].decode(bytes(7) + b"\x01") == 1 << 56
    assert vendor["Wrapped"].type is DataType.U16
    assert vendor["Middle"].key == (0x2007, 2)
    assert vendor["Program"].type is DataType.DOMAIN
    assert (vendor["Program"].readable, vendor["Program"].writable) == (False, True)
    assert (vendor["Device Type"].access, vendor["0x2000:1"].access) == ("ro", "rw")


def test_what_is_odd_is_named(vendor: Dictionary) -> None:
    for expected in (
        "[DeviceInfo] ProductNumber 'none' is not understood; left out",
        "[2000suba] DefaultValue 'nan' is not understood; left out",
        "[2002] DataType 0x0016 is unknown; bytes are used",
        "[2003] no ParameterName; called 0x2003:0",
        "[2003] AccessType 'sometimes' is unknown; ro is used",
        "[2003] LowLimit 9 is above HighLimit 3; no limits are used",
        "[2003] DefaultValue '70000' is not understood; left out",
        "[2009] a record or array without sub-indices; left out",
    ):
        assert expected in vendor.warnings
    text = "\n".join(vendor.warnings)
    assert re.search(r"line \d+: 'this line means nothing' is neither", text)
    assert re.search(r"line \d+: section \[2001\] again", text)
    assert len(vendor.warnings) == 10


@pytest.mark.parametrize("name", ["Offset", "0x2001", "0x2001:0", "0X2001:0", (0x2001, 0)])
def test_lookup(vendor: Dictionary, name: str | tuple[int, int]) -> None:
    assert vendor[name].name == "Offset"
    assert name in vendor


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Offsett", "no object 'Offsett' in vendor.eds: did you mean 'Offset'?"),
        ("xyz", "no object 'xyz' in vendor.eds: give a name or 0xINDEX:SUB from it"),
        ("0x5555:1", "no object '0x5555:1' in vendor.eds"),
        ((0x5555, 1), "no object 0x5555:1 in vendor.eds"),
    ],
)
def test_lookup_of_a_missing_object(vendor: Dictionary, name: str | tuple[int, int], message: str) -> None:
    assert name not in vendor
    with pytest.raises(ValueRefused, match=re.escape(message)):
        vendor[name]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings_and_line_ends(encoding: str, vendor: Dictionary) -> None:
    for line_end in ("\n", "\r\n"):
        data = VENDOR.replace("\n", line_end).encode(encoding)
        read = Dictionary.from_bytes(data, 5, "vendor.eds")
        assert read.identity == vendor.identity
        assert read.variables == vendor.variables


def test_a_dcf_of_the_same_object_table_has_its_limits_as_floats() -> None:
    dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
    assert (dictionary["L_d"].minimum, dictionary["L_d"].maximum) == (1e-6, 1.0)
    assert dictionary["R_s"].default == 0.1
    assert dictionary["law"].default == "tpc"
    assert dictionary["producer_heartbeat"].maximum == 60.0
    assert not dictionary["pole_pairs"].enabled_write


@pytest.mark.parametrize("content", [b"", b"\x7fELF\x02\x01\0\0", b"[FileInfo]\nFileName=x\n", b"[1000]\n\0"])
def test_a_file_that_is_no_eds_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "garbled.eds"
    path.write_bytes(content)
    with pytest.raises(DictionaryError, match=r"garbled\.eds: no object in it, an EDS or DCF") as refused:
        Dictionary.from_eds(path, 1)
    assert "\n" not in str(refused.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "missing.eds"):
        with pytest.raises(DictionaryError, match=re.escape(f"cannot read {path}")):
            Dictionary.from_eds(path, 1)


@given(st.binary(max_size=300))
def test_any_bytes_give_a_dictionary_or_a_dictionary_error(noise: bytes) -> None:
    for data in (noise, b"[1000]\nDataType=7\n" + noise):
        try:
            dictionary = Dictionary.from_bytes(data, 5, "noise.eds")
        except DictionaryError:
            continue
        assert len(dictionary.by_key) == len(dictionary)


KEYS = ("ParameterName", "ObjectType", "DataType", "AccessType", "LowLimit", "HighLimit", "DefaultValue")
EXTRAS = ("Factor", "Unit", "Values", "PDOMapping", "CompactSubObj", "Role")
VALUES = st.sampled_from(
    [
        "",
        "0",
        "7",
        "8",
        "9",
        "0x8",
        "-1",
        "1e400",
        "0x7F800000",
        "0xFFFFFFFFFF",
        "$NODEID",
        "$NODEID+x",
        "a:b",
        "a:1",
    ]
) | st.text(alphabet="0123456789abxX$+-.:;,#[]= ", max_size=6)


@given(st.dictionaries(st.sampled_from(KEYS + EXTRAS), VALUES, max_size=9))
def test_any_values_of_any_keys_are_survived(keys: dict[str, str]) -> None:
    lines = [f"{key}={value}" for key, value in keys.items()]
    text = "\n".join(["[2000]", *lines, "[2000sub1]", *lines, "[2001]", *lines])
    for variable in Dictionary.from_bytes(text.encode("utf-8", "replace"), 5, "odd.eds"):
        assert variable.factor != 0
        assert math.isfinite(variable.factor)
        assert isinstance(variable.default, int | float | str | None)


# ---- sub-sections without content, and the values of a DCF -------------------------------------------------

EMPTY_SUBS = """\
[100B]
ParameterName=Node number
ObjectType=0x7
DataType=0x0005
AccessType=rw
DefaultValue=0x01
LowLimit=0x00
HighLimit=0x7F
[100BSub0]
SubNumber=1
[2001]
ParameterName=Half described
ObjectType=0x7
DataType=0x0006
AccessType=rw
[2001sub0]
ParameterName=By its sub-section
[2002]
ParameterName=Gains
ObjectType=0x8
SubNumber=3
[2002sub0]
ParameterName=Entries
DataType=5
AccessType=ro
[2002sub1]
ParameterName=K_p
DataType=8
AccessType=rw
[2002sub2]
[2003]
ParameterName=Nothing
[2003sub0]
"""


def test_an_empty_sub_section_makes_no_domain_of_its_object() -> None:
    dictionary = Dictionary.from_bytes(EMPTY_SUBS.encode(), 1, "empty.eds")
    number = dictionary[0x100B, 0]
    assert (number.name, number.type, number.access) == ("Node number", DataType.U8, "rw")
    assert (number.raw_default, number.raw_minimum, number.raw_maximum) == (1, 0, 127)
    half = dictionary[0x2001, 0]
    assert (half.name, half.type, half.access) == ("By its sub-section", DataType.U16, "rw")
    assert dictionary[0x2002, 1].type is DataType.F32
    assert (0x2002, 2) not in dictionary
    named = [each for each in dictionary.warnings if "empty" in each]
    assert [each.partition("]")[0] for each in named] == ["[100bsub0", "[2002sub2", "[2003sub0"]
    assert "'Node number'" in named[0]
    assert "'Gains'" in named[1]


DCF = """\
[1017]
ParameterName=Producer heartbeat
DataType=6
AccessType=rw
DefaultValue=0
ParameterValue=100
[1400sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
ParameterValue=$NODEID+0x200
[2000]
ParameterName=Gain
DataType=8
AccessType=rw
ParameterValue=0x3F000000
[2001]
ParameterName=Label
DataType=9
AccessType=rw
ParameterValue=axis 1
[2002]
ParameterName=Table
ObjectType=8
DataType=3
AccessType=rw
DefaultValue=5
CompactSubObj=3
[2002Value]
NrOfEntries=1
2=-7
[2003]
ParameterName=Broken
DataType=5
AccessType=rw
ParameterValue=much
[2004]
ParameterName=Not configured
DataType=5
AccessType=rw
DefaultValue=3
ParameterValue=
"""


def test_a_dcf_tells_what_it_configures() -> None:
    dictionary = Dictionary.from_bytes(DCF.encode(), 5, "any.dcf")
    configured = {each.label: each.configured for each in dictionary if each.configured is not None}
    assert configured == {
        "0x1017:0": 100,
        "0x1400:1": 0x205,
        "0x2000:0": 0.5,
        "0x2001:0": "axis 1",
        "0x2002:2": -7,
    }
    assert dictionary[0x1017, 0].default == 0
    assert dictionary[0x2002, 2].default == 5
    assert any("[2003] ParameterValue 'much'" in each for each in dictionary.warnings)


def test_the_drive_s_own_file_has_no_mapping_of_a_domain() -> None:
    section = ""
    domains: dict[str, list[str]] = {}
    for line in (shipped("firmware_protocol") / "drive.eds").read_text(encoding="utf-8").splitlines():
        section = line if line.startswith("[") else section
        domains.setdefault(section, []).append(line)
    of_domains = [lines for lines in domains.values() if "DataType=0x000F" in lines]
    assert of_domains
    assert not any(line.startswith("PDOMapping") for lines in of_domains for line in lines)
