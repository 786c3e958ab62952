"""Identity of the drive, checked against the profile's dictionary."""

from __future__ import annotations

from dataclasses import dataclass

from benchtool.errors import DictionaryMismatch, IdentityMismatch
from benchtool.protocol.dictionary import Dictionary


@dataclass(frozen=True)
class Identity:
    """Objects 0x1018, 0x1008 to 0x100A and the dictionary hash; None where the drive does not provide
    them."""

    vendor_id: int | None
    product_code: int | None
    revision_number: int | None
    serial_number: int | None
    device_name: str | None
    hardware_version: str | None
    firmware_version: str | None
    dictionary_hash: int | None

    def require(self, dictionary: Dictionary, source: str) -> None:
        """Check that this is the drive of `dictionary`, which was read from `source`.

        A vendor or a product that the file does not state, or the drive does not provide, is not compared.

        Raises:
            IdentityMismatch: another vendor or product.
            DictionaryMismatch: another version of the dictionary.
        """
        expected = dictionary.identity
        if differs(self.vendor_id, expected.vendor_id) or differs(self.product_code, expected.product_code):
            raise IdentityMismatch(
                f"the node is {described(self.vendor_id, self.product_code)}; {source} describes "
                f"{described(expected.vendor_id, expected.product_code)}: check the node id or choose the "
                f"profile of this drive"
            )
        if dictionary.hash is not None and self.dictionary_hash != dictionary.hash:
            seen = "none" if self.dictionary_hash is None else f"0x{self.dictionary_hash:08X}"
            raise DictionaryMismatch(
                f"the drive speaks dictionary {seen}, {source} is 0x{dictionary.hash:08X}: "
                f"use the EDS of its firmware {self.firmware_version or '(unknown)'} or update the firmware"
            )


def differs(one: int | None, other: int | None) -> bool:
    """Return whether both are known and not the same."""
    return one is not None and other is not None and one != other


def described(vendor_id: int | None, product_code: int | None) -> str:
    """Return the vendor and product in words, whichever are known."""
    vendor, product = (
        "(not stated)" if each is None else f"0x{each:08X}" for each in (vendor_id, product_code)
    )
    return f"vendor {vendor}, product {product}"
