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

/* Trip levels far from what limits them, so that every parameter takes the limits of its own. */
static void make_room(void)
{
    static const enum bt_id upper[] = { BT_ID_omega_m_N, BT_ID_u_dc_max };
    static const enum bt_id lower[] = { BT_ID_omega_m_trip, BT_ID_u_dc_min };
    unsigned k;
    for (k = 0; k < 2; k++) {
        assert(host_write(&drive, upper[k], bt_entries[upper[k]].high.u) == BT_OK);
        assert(host_write(&drive, lower[k], bt_entries[lower[k]].low.u) == BT_OK);
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

static float number(enum bt_id id)
{
    return bt_float_of(host_read(&drive, id));
}

/* `most` is taken and the next float above it refused, and that changes nothing. */
static void check_most(enum bt_id id, float most)
{
    assert(host_write(&drive, id, bt_word_of(most)) == BT_OK);
    assert(host_write(&drive, id, bt_word_of(nextafterf(most, INFINITY))) == BT_ABORT_VALUE_HIGH);
    assert(number(id) == most);
}

/* Trip levels stay within what the sensors reach, whichever of two related values is written. */
static void check_relations(void)
{
    struct bt_config config = check_config();
    uint32_t words[BT_STORED_WORDS];
    config.i_full_scale = 20.0f;
    config.u_dc_full_scale = 100.0f;
    check_power_up_as(&drive, &config);
    assert(number(BT_ID_i_full_scale) == 20.0f && number(BT_ID_u_dc_full_scale) == 100.0f);
    assert(number(BT_ID_u_dc_max) == 100.0f); /* its default is 400 V */
    assert(number(BT_ID_i2t_current) == 20.0f);
    check_most(BT_ID_i_trip, 20.0f);
    check_most(BT_ID_u_dc_max, 100.0f);
    check_most(BT_ID_u_dc_min, 100.0f);
    assert(host_write(&drive, BT_ID_u_dc_max, bt_word_of(99.0f)) == BT_ABORT_VALUE_LOW);
    assert(host_write(&drive, BT_ID_u_dc_min, bt_word_of(50.0f)) == BT_OK);
    assert(host_write(&drive, BT_ID_u_dc_max, bt_word_of(50.0f)) == BT_OK);
    assert(host_write(&drive, BT_ID_u_dc_min, bt_word_of(100.0f / 64.0f)) == BT_OK);
    assert(host_write(&drive, BT_ID_u_dc_min, bt_word_of(1.5f)) == BT_ABORT_VALUE_LOW);
    check_most(BT_ID_i2t_current, 20.0f);
    check_most(BT_ID_omega_m_trip, 10.0f * number(BT_ID_omega_m_N));
    assert(host_write(&drive, BT_ID_omega_m_N, bt_word_of(99.0f)) == BT_ABORT_PARAMETER_INCOMPATIBLE);
    assert(number(BT_ID_omega_m_N) == 100.0f);
    host_nmt(&drive, BT_NMT_RESET_NODE);
    assert(number(BT_ID_i_full_scale) == 20.0f && number(BT_ID_u_dc_max) == 100.0f);

    check_most(BT_ID_i_trip, 20.0f);
    assert(host_write(&drive, BT_ID_omega_m_N, bt_word_of(200.0f)) == BT_OK);
    check_most(BT_ID_omega_m_trip, 2000.0f); /* allowed beside the kept rated speed, not beside the default */
    assert(host_write(&drive, BT_ID_store_all, 0x65766173u) == BT_OK);
    memcpy(words, drive.node.device.stored, sizeof words);
    config.i_full_scale = 15.0f; /* of a smaller converter */
    check_power_up_as(&drive, &config);
    assert(!bt_restore(&drive, words, BT_STORED_WORDS) && number(BT_ID_i_trip) == 10.0f);
    config.i_full_scale = 20.0f;
    check_power_up_as(&drive, &config);
    assert(bt_restore(&drive, words, BT_STORED_WORDS) && number(BT_ID_i_trip) == 20.0f);

    config.i_full_scale = config.u_dc_full_scale = 5.0f; /* below every default, that of u_dc_min too */
    check_power_up_as(&drive, &config);
    assert(number(BT_ID_i_trip) == 5.0f && number(BT_ID_u_dc_max) == 5.0f && number(BT_ID_u_dc_min) == 5.0f);
}

/* The PWM period is that of control, or what the firmware says. */
static void check_periods(void)
{
    struct bt_config config = check_config();
    check_power_up_as(&drive, &config);
    assert(bt_variables(&drive)->pwm_period == bt_variables(&drive)->control_period);
    config.pwm_period_ns = 2u * config.tick_period_ns;
    check_power_up_as(&drive, &config);
    assert(bt_variables(&drive)->pwm_period == 2.0f * bt_variables(&drive)->control_period);
}

void check_objects(void)
{
    unsigned id, limited = 0;
    check_find();
    check_periods();
    check_power_up(&drive);
    assert(host_read(&drive, BT_ID_dictionary_hash) == BT_DICTIONARY_HASH);
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        const struct bt_entry *entry = &bt_entries[id];
        if (entry->role == BT_ROLE_PARAMETER && entry->access == BT_ACCESS_RW) {
            make_room();
            check_limits((enum bt_id)id);
            limited++;
        }
        check_lengths((enum bt_id)id);
    }
    check_relations();
    check_power_up(&drive);
    host_enable(&drive);
    assert(host_write(&drive, BT_ID_pole_pairs, 3) == BT_ABORT_DEVICE_STATE);
    assert(host_read(&drive, BT_ID_pole_pairs) == bt_entries[BT_ID_pole_pairs].initial.u);
    printf("objects: %u entries, %u with limits\n", (unsigned)BT_ENTRY_COUNT, limited);
}
