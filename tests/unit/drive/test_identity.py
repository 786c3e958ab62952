"""Identity where the file or the drive leaves part of it open: never an error of its own."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import pytest

from benchtool.clock import VirtualClock
from benchtool.drive.identity import Identity
from benchtool.drive.node import RemoteNode
from benchtool.errors import IdentityMismatch, SdoAbort
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.dictionary import Dictionary

VENDOR, PRODUCT, REVISION = 0x9A, 0x30923, 7
KEYS = {"VendorNumber": VENDOR, "ProductNumber": PRODUCT, "RevisionNumber": REVISION}


def file_with(stated: tuple[str, ...], listed: bool = True) -> Dictionary:
    """An EDS that states these, and lists its identity object or not."""
    lines = ["[DeviceInfo]", "VendorName=Any", *(f"{key}=0x{KEYS[key]:X}" for key in stated)]
    lines += ["[6041]", "ParameterName=Statusword", "ObjectType=7", "DataType=6", "AccessType=ro"]
    if listed:
        lines += ["[1018]", "ParameterName=Identity", "ObjectType=9", "SubNumber=2"]
        lines += ["[1018sub1]", "ParameterName=Vendor-ID", "DataType=7", "AccessType=ro"]
    return Dictionary.from_bytes("\n".join(lines).encode(), 1, "any.eds")


def drive_with(told: dict[int, int], dictionary: Dictionary) -> RemoteNode:
    """A node whose identity object has these entries."""

    def upload(index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        if index == 0x1018 and sub in told:
            return told[sub].to_bytes(4, "little")
        raise SdoAbort("no such object", Abort.NO_OBJECT)

    link: Any = SimpleNamespace(upload=upload)
    return RemoteNode(link, dictionary, "any.eds", VirtualClock())


SUBSETS = [subset for n in range(4) for subset in itertools.combinations(KEYS, n)]


@pytest.mark.parametrize("stated", SUBSETS)
@pytest.mark.parametrize("told", [(), (1,), (2,), (1, 2), (1, 2, 3, 4)])
@pytest.mark.parametrize("listed", [True, False])
def test_what_is_not_known_on_both_sides_is_not_compared(
    stated: tuple[str, ...], told: tuple[int, ...], listed: bool
) -> None:
    values = {1: VENDOR, 2: PRODUCT, 3: REVISION, 4: 99}
    node = drive_with({sub: values[sub] for sub in told}, file_with(stated, listed))
    identity = node.check()
    assert identity.vendor_id == (VENDOR if 1 in told else None)
    assert identity.product_code == (PRODUCT if 2 in told else None)
    assert identity.serial_number == (99 if 4 in told else None)
    assert identity.device_name is None


@pytest.mark.parametrize("stated", [subset for subset in SUBSETS if set(subset) & {"VendorNumber"}])
@pytest.mark.parametrize("told", [{1: 5}, {1: 5, 2: PRODUCT}])
def test_another_vendor_is_refused_whatever_else_is_missing(
    stated: tuple[str, ...], told: dict[int, int]
) -> None:
    with pytest.raises(IdentityMismatch, match=r"vendor 0x00000005.*any\.eds describes vendor 0x0000009A"):
        drive_with(told, file_with(stated)).check()


def test_another_product_is_refused_without_a_vendor() -> None:
    identity = Identity(None, 5, None, None, None, None, None, None)
    with pytest.raises(IdentityMismatch, match=r"vendor \(not stated\), product 0x00000005"):
        identity.require(file_with(("ProductNumber",)), "any.eds")
