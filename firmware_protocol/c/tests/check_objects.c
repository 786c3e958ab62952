/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Every entry of the dictionary: found, read, written at its limits and beyond them. */
#undef NDEBUG
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "check.h"
#include "host.h"

static struct bt_drive drive;

static void check_find(void)
{
    uint32_t index, known = 0;
    unsigned sub;
    enum bt_id id;
    for (index = 0; index <= 0xFFFFu; index++) {
        for (sub = 0; sub < 256; sub++) {
            const uint32_t status = bt_find((uint16_t)index, (uint8_t)sub, &id);
            if (status == BT_OK) {
                assert(id == known && bt_entries[id].index == index && bt_entries[id].sub == sub);
                known++;
            } else {
                const bool there = (known > 0 && bt_entries[known - 1u].index == index) ||
                                   (known < BT_ENTRY_COUNT && bt_entries[known].index == index);
                assert(id == BT_ID_NONE);
                assert(status == (there ? BT_ABORT_NO_SUB_INDEX : BT_ABORT_NO_OBJECT));
            }
        }
    }
    assert(known == BT_ENTRY_COUNT);
}

static void check_lengths(enum bt_id id)
{
    uint8_t data[8] = { 0 };
    const struct bt_entry *entry = &bt_entries[id];
    size_t n;
    for (n = 1; n <= sizeof data; n++) {
        const uint32_t status = bt_write(&drive.node.device, entry->index, entry->sub, data, n);
        if (entry->access != BT_ACCESS_RW && entry->access != BT_ACCESS_WO)
            assert(status == BT_ABORT_READ_ONLY);
        else if (n != entry->size)
            assert(status == (n < entry->size ? BT_ABORT_LENGTH_LOW : BT_ABORT_LENGTH_HIGH));
    }
}

/* A parameter takes its limits and nothing beyond; what is refused leaves the variable as it was. */
static void check_limits(enum bt_id id)
{
    const struct bt_entry *entry = &bt_entries[id];
    uint32_t before;
    if (entry->type == BT_TYPE_F32) {
        assert(host_write(&drive, id, entry->low.u) == BT_OK && host_read(&drive, id) == entry->low.u);
        assert(host_write(&drive, id, entry->high.u) == BT_OK && host_read(&drive, id) == entry->high.u);
        before = entry->high.u;
        assert(host_write(&drive, id, bt_word_of(nextafterf(entry->high.f, INFINITY))) == BT_ABORT_VALUE_HIGH);
        assert(host_write(&drive, id, bt_word_of(nextafterf(entry->low.f, -INFINITY))) == BT_ABORT_VALUE_LOW);
        assert(host_write(&drive, id, bt_word_of(NAN)) == BT_ABORT_VALUE);
        assert(host_write(&drive, id, bt_word_of(INFINITY)) == BT_ABORT_VALUE);
        assert(host_write(&drive, id, bt_word_of(-INFINITY)) == BT_ABORT_VALUE);
    } else {
        before = host_read(&drive, id);
        if (entry->size == 4 && entry->high.u != UINT32_MAX)
            assert(host_write(&drive, id, entry->high.u + 1u) == BT_ABORT_VALUE_HIGH);
        if (entry->size == 4 && entry->low.u > 0)
            assert(host_write(&drive, id, entry->low.u - 1u) == BT_ABORT_VALUE_LOW);
    }
    assert(host_read(&drive, id) == before);
}

void check_objects(void)
{
    unsigned id, limited = 0;
    check_find();
    check_power_up(&drive);
    assert(host_read(&drive, BT_ID_dictionary_hash) == BT_DICTIONARY_HASH);
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        const struct bt_entry *entry = &bt_entries[id];
        if (entry->role == BT_ROLE_PARAMETER && entry->access == BT_ACCESS_RW) {
            check_limits((enum bt_id)id);
            limited++;
        }
        check_lengths((enum bt_id)id);
    }
    check_power_up(&drive);
    host_enable(&drive);
    assert(host_write(&drive, BT_ID_pole_pairs, 3) == BT_ABORT_DEVICE_STATE);
    assert(host_read(&drive, BT_ID_pole_pairs) == bt_entries[BT_ID_pole_pairs].initial.u);
    printf("objects: %u entries, %u with limits\n", (unsigned)BT_ENTRY_COUNT, limited);
}
