"""Relations between two values of the drive's own dictionary."""

from __future__ import annotations

from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.relations import relations
from benchtool.shipped import shipped


def test_each_is_stated_once_also_where_both_ends_name_it() -> None:
    dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
    assert dictionary["u_dc_min"].max_entry == "u_dc_max"
    assert dictionary["u_dc_max"].min_entry == "u_dc_min"
    pairs = [(each.lower.name, each.upper.name) for each in relations(dictionary)]
    assert pairs.count(("u_dc_min", "u_dc_max")) == 1
    assert len(pairs) == len(set(pairs))
