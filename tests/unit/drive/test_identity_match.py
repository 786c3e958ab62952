"""Whether a node is the drive that a dictionary describes: vendor, product and hash."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchtool.drive.identity import Identity
from benchtool.errors import DictionaryMismatch, IdentityMismatch
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
EXPECTED = DICTIONARY.identity
THE_DRIVE = Identity(
    vendor_id=EXPECTED.vendor_id or 0,
    product_code=EXPECTED.product_code or 0,
    revision_number=1,
    serial_number=7,
    device_name="drive",
    hardware_version="A",
    firmware_version="0.1.0",
    dictionary_hash=DICTIONARY.hash,
)


def test_the_drive_itself_is_taken_whatever_its_serial_number() -> None:
    THE_DRIVE.require(DICTIONARY, "drive.eds")
    replace(THE_DRIVE, serial_number=8, revision_number=None).require(DICTIONARY, "drive.eds")


@pytest.mark.parametrize(
    "other",
    [
        replace(THE_DRIVE, vendor_id=(EXPECTED.vendor_id or 0) + 1),
        replace(THE_DRIVE, product_code=(EXPECTED.product_code or 0) + 1),
    ],
    ids=["vendor", "product"],
)
def test_another_vendor_or_product_is_refused_with_both_named(other: Identity) -> None:
    with pytest.raises(IdentityMismatch) as refused:
        other.require(DICTIONARY, "drive.eds")
    for identity in (THE_DRIVE, other):
        text = f"vendor 0x{identity.vendor_id:08X}, product 0x{identity.product_code:08X}"
        assert text in str(refused.value)


@pytest.mark.parametrize("seen", [None, 0, (DICTIONARY.hash or 0) ^ 1])
def test_another_dictionary_is_refused(seen: int | None) -> None:
    with pytest.raises(DictionaryMismatch, match=f"0x{DICTIONARY.hash:08X}"):
        replace(THE_DRIVE, dictionary_hash=seen).require(DICTIONARY, "drive.eds")
