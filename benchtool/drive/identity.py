"""Who answers, and whether it is the drive that the profile's dictionary describes."""

from __future__ import annotations

from dataclasses import dataclass

from benchtool.errors import DictionaryMismatch, IdentityMismatch
from benchtool.protocol.dictionary import Dictionary


@dataclass(frozen=True)
class Identity:
    """Objects 0x1018, 0x1008 to 0x100A and the dictionary hash; None where the drive has no such object."""

    vendor_id: int
    product_code: int
    revision_number: int | None
    serial_number: int | None
    device_name: str | None
    hardware_version: str | None
    firmware_version: str | None
    dictionary_hash: int | None

    def require(self, dictionary: Dictionary, source: str) -> None:
        """Check that this is the drive of `dictionary`, which was read from `source`.

        Raises:
            IdentityMismatch: another vendor or product.
            DictionaryMismatch: another version of the dictionary.
        """
        expected = dictionary.identity
        if (self.vendor_id, self.product_code) != (expected.vendor_id, expected.product_code):
            raise IdentityMismatch(
                f"the node is vendor 0x{self.vendor_id:08X}, product 0x{self.product_code:08X}; {source} "
                f"describes vendor 0x{expected.vendor_id:08X}, product 0x{expected.product_code:08X}: "
                f"check the node id or choose the profile of this drive"
            )
        if dictionary.hash is not None and self.dictionary_hash != dictionary.hash:
            seen = "none" if self.dictionary_hash is None else f"0x{self.dictionary_hash:08X}"
            raise DictionaryMismatch(
                f"the drive speaks dictionary {seen}, {source} is 0x{dictionary.hash:08X}: "
                f"use the EDS of its firmware {self.firmware_version or '(unknown)'} or update the firmware"
            )
