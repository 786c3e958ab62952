"""Objects that the table states once and repeats."""

from __future__ import annotations

from benchtool.protocol.canopen.cob_id import INVALID, RPDO, TPDO
from benchtool.protocol.canopen.pdo import rpdo, tpdo
from benchtool.protocol.dictionary.objects import load_table
from benchtool.shipped import shipped

TABLE = load_table(shipped("firmware_protocol") / "objects.toml")


def test_each_copy_has_its_index_its_names_and_its_defaults() -> None:
    for number, cob_id in enumerate(TPDO, start=1):
        entry = TABLE.by_key[0x1800 + number - 1, 1]
        assert (entry.name, entry.default) == (f"tpdo{number}_cob_id", 0xC0000000 | cob_id)
        assert entry.add_node_id
        assert TABLE.by_key[0x1A00 + number - 1, 4].name == f"tpdo{number}_mapping_4"
    for number, cob_id in enumerate(RPDO, start=1):
        assert TABLE.by_key[0x1400 + number - 1, 1].default == INVALID | cob_id
    assert (0x1808, 1) not in TABLE.by_key
    assert "{n}" not in "".join(f"{entry.name}{entry.description}" for entry in TABLE)


def test_sub_index_0_tells_the_highest_or_what_it_was_given() -> None:
    assert TABLE.by_key[0x1800, 0].default == 5, "sub-indices 3 and 4 are left out"
    mapping = TABLE.by_key[0x1A00, 0]
    assert (mapping.default, mapping.access) == (0, "rw")


def test_a_pdo_is_set_up_in_the_order_of_cia_301() -> None:
    assert list(tpdo(3, [0x20300120, 0x20300C20], 2).set_up(0.01)) == [
        ("0x1801:1", INVALID | 0x283),
        ("0x1801:2", 255),
        ("0x1801:5", 0.01),
        ("0x1A01:0", 0),
        ("0x1A01:1", 0x20300120),
        ("0x1A01:2", 0x20300C20),
        ("0x1A01:0", 2),
        ("0x1801:1", 0x283),
    ]
    labels = [label for label, _ in rpdo(3, [0x20200120]).set_up()]
    assert labels == ["0x1400:1", "0x1400:2", "0x1600:0", "0x1600:1", "0x1600:0", "0x1400:1"]
