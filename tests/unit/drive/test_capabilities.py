"""Capabilities of a drive, by the objects of its dictionary alone."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchtool.drive.capabilities import Capabilities, Capability
from benchtool.errors import CapabilityMissing
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.roles import Role
from benchtool.shipped import shipped
from tests.third_party_drives import stripped_eds, third_party_eds

OWN = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
OF_BENCHTOOL = {Capability.STREAM, Capability.CAPTURE, Capability.STIMULUS, Capability.TICK}


def capabilities_of(eds: bytes) -> Capabilities:
    return Capabilities.of(Dictionary.from_bytes(eds, 1, "vendor/any.eds"))


def available(capabilities: Capabilities) -> set[Capability]:
    return {each for each in Capability if each in capabilities}


def test_the_reference_drive_can_do_all_but_positions() -> None:
    assert available(Capabilities.of(OWN)) == set(Capability) - {Capability.POSITION}


def test_another_makers_drive_has_what_the_standards_have() -> None:
    found = capabilities_of(third_party_eds())
    assert available(found) == set(Capability) - OF_BENCHTOOL
    assert found.findings[Capability.SUPERVISED].by == (
        "0x1016:1 consumer_heartbeat",
        "0x6007:0 abort_connection_option",
    )
    assert found.findings[Capability.TICK].missing == ("tick", "control_period")


@pytest.mark.parametrize(
    ("section", "lost"),
    [
        ("1016sub1", {Capability.SUPERVISED}),
        ("1010sub1", {Capability.STORAGE}),
        ("6071", {Capability.TORQUE}),
        ("60FF", {Capability.VELOCITY}),
        ("607A", {Capability.POSITION}),
        ("6040", {Capability.TORQUE, Capability.VELOCITY, Capability.POSITION}),
        ("6041", {Capability.TORQUE, Capability.VELOCITY, Capability.POSITION}),
        ("6060", {Capability.TORQUE, Capability.VELOCITY, Capability.POSITION}),
        ("6007", set()),
        ("6076", set()),
        ("6502", set()),
    ],
)
def test_an_object_that_is_missing_takes_what_needs_it(section: str, lost: set[Capability]) -> None:
    everything = set(Capability) - OF_BENCHTOOL
    found = capabilities_of(third_party_eds(without=[section]))
    assert available(found) == everything - lost
    for each in lost:
        (missing,) = found.findings[each].missing
        assert missing.startswith(f"0x{section[:4]}:")


@pytest.mark.parametrize("section", ["1016sub1", "6040", "6060", "6071", "1010sub1"])
def test_an_object_that_cannot_be_written_is_missing(section: str) -> None:
    found = capabilities_of(third_party_eds(changed={section: {"AccessType": "ro"}}))
    assert len(available(found)) < len(Capability) - len(OF_BENCHTOOL)
    missing = [each for finding in found.findings.values() for each in finding.missing]
    said = [each for each in missing if each.startswith(f"0x{section[:4]}:")]
    assert all(each.endswith(", a writable number") for each in said)
    assert said


def test_an_object_of_an_unknown_type_is_no_number() -> None:
    found = capabilities_of(third_party_eds(changed={"6041": {"DataType": "0x0043"}}))
    assert found.findings[Capability.TORQUE].missing == ("0x6041:0 statusword, a readable number",)


@pytest.mark.parametrize(
    ("supported", "lost"),
    [
        ("0x25", {Capability.TORQUE}),  # profile position, profile velocity, homing
        ("0x380", set()),  # cyclic synchronous position, velocity and torque
        ("0x8", {Capability.VELOCITY, Capability.POSITION}),
        ("0", set()),  # which no drive is: the file leaves it open
    ],
)
def test_modes_that_the_file_says_the_drive_has_not(supported: str, lost: set[Capability]) -> None:
    found = capabilities_of(third_party_eds(changed={"6502": {"DefaultValue": supported}}))
    assert available(found) == set(Capability) - OF_BENCHTOOL - lost


@pytest.mark.parametrize("name", [variable.name for variable in OWN if 0x2020 <= variable.index < 0x2060])
def test_each_object_of_benchtools_own_is_needed_or_not_used(name: str) -> None:
    """Leaving one out takes exactly the capabilities that list it."""
    whole = Capabilities.of(OWN)
    users = {
        each for each, finding in whole.findings.items() if any(by.endswith(f" {name}") for by in finding.by)
    }
    variables = {key: each for key, each in OWN.variables.items() if key != name}
    assert available(whole) - available(Capabilities.of(replace(OWN, variables=variables))) == users


@pytest.mark.parametrize("capability", list(Capability))
def test_a_refusal_names_the_capability_what_is_missing_and_what_that_costs(capability: Capability) -> None:
    empty = capabilities_of(
        b"[1000]\r\nParameterName=Type\r\nObjectType=7\r\nDataType=7\r\nAccessType=ro\r\n"
    )
    assert available(empty) == set()
    with pytest.raises(CapabilityMissing) as refused:
        empty.require(capability, purpose="a test")
    said = str(refused.value)
    assert said.startswith(f"no '{capability}': ")
    assert empty.findings[capability].missing[0] in said
    assert "a test takes it, and any.eds has not" in said
    assert said.endswith("nothing was sent")
    assert ("[roles]" in said) is (capability not in OF_BENCHTOOL)
    assert refused.value.exit_code == 2


def test_a_long_list_is_cut_and_its_rest_counted() -> None:
    with pytest.raises(
        CapabilityMissing, match="has not tick, control_period, capture_control, capture_rows and 10 more:"
    ):
        capabilities_of(third_party_eds()).require(Capability.CAPTURE, purpose="a test")
    with pytest.raises(CapabilityMissing, match="has not tick, control_period: it takes"):
        capabilities_of(third_party_eds()).require(Capability.TICK, purpose="a test")


def test_what_is_there_is_not_refused() -> None:
    whole = Capabilities.of(OWN)
    whole.require(*(set(Capability) - {Capability.POSITION}), purpose="a test")
    with pytest.raises(CapabilityMissing, match="no 'position'"):
        whole.require(Capability.TICK, Capability.POSITION, purpose="a test")


def test_the_document_has_each_capability_with_its_objects() -> None:
    document = capabilities_of(stripped_eds(without=["6071"])).to_json()
    assert list(document) == [str(each) for each in Capability]
    for finding in document.values():
        assert set(finding) == {"available", "by", "missing"}
        assert bool(finding["by"]) is finding["available"]
        assert bool(finding["missing"]) is not finding["available"]


def test_no_two_roles_are_of_one_object() -> None:
    assert len({role.key for role in Role}) == len(Role) == len(Role.__members__)
