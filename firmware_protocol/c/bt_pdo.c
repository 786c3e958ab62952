/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_pdo.h"

#define INVALID 0x80000000u
#define ENTRIES 4u
#define LONGEST_BITS 64u
#define MAPPING_OF 0x200u /* from a communication object to its mapping object */

static uint32_t load(const struct bt_variables *variables, uint16_t index, uint8_t sub)
{
    enum bt_id id;
    return bt_find(index, sub, &id) == BT_OK ? bt_load(variables, id).u : 0;
}

static uint32_t check_cob_id(uint32_t now, uint32_t value)
{
    const uint32_t can_id = value & 0x7FFu;
    if (!(now & INVALID) && !(value & INVALID) && value != now)
        return BT_ABORT_VALUE;
    /* Identifiers of 29 bits are not supported; those of NMT, SYNC, EMCY and SDO are not for process data. */
    return value >> 11 & 0x7FFFFu || can_id < 0x181u || can_id > 0x57Fu ? BT_ABORT_VALUE : BT_OK;
}

/* The entry that a mapping names, if such a PDO may carry it. */
static uint32_t find_mapped(uint32_t mapping, bool is_transmitted, enum bt_id *id)
{
    const struct bt_entry *entry;
    if (bt_find((uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), id) != BT_OK)
        return BT_ABORT_NO_OBJECT;
    entry = &bt_entries[*id];
    if (!bt_is_mappable(entry) || bt_mapping(entry) != mapping)
        return BT_ABORT_NOT_MAPPABLE;
    if (is_transmitted)
        return entry->access == BT_ACCESS_WO ? BT_ABORT_NOT_MAPPABLE : BT_OK;
    return entry->access == BT_ACCESS_RW || entry->access == BT_ACCESS_WO ? BT_OK : BT_ABORT_NOT_MAPPABLE;
}

static uint32_t check_count(const struct bt_variables *variables, uint16_t index, bool is_transmitted, uint32_t count)
{
    uint32_t bits = 0;
    uint8_t sub;
    if (count > ENTRIES)
        return BT_ABORT_VALUE_HIGH;
    for (sub = 1; sub <= count; sub++) {
        enum bt_id id;
        const uint32_t status = find_mapped(load(variables, index, sub), is_transmitted, &id);
        if (status != BT_OK)
            return status;
        bits += bt_entries[id].size * 8u;
    }
    return bits > LONGEST_BITS ? BT_ABORT_MAPPING_TOO_LONG : BT_OK;
}

uint32_t bt_pdo_check(const struct bt_variables *variables, enum bt_id id, uint32_t value)
{
    const uint16_t index = bt_entries[id].index;
    const uint8_t sub = bt_entries[id].sub;
    const bool is_transmitted = index >= 0x1800u;
    enum bt_id mapped;
    if (index < 0x1400u || index >= 0x1C00u)
        return BT_OK;
    if ((index & MAPPING_OF) == 0)
        return sub == 1u ? check_cob_id(load(variables, index, 1), value) : BT_OK;
    if (!(load(variables, (uint16_t)(index - MAPPING_OF), 1) & INVALID))
        return BT_ABORT_UNSUPPORTED_ACCESS;
    if (sub == 0)
        return check_count(variables, index, is_transmitted, value);
    if (load(variables, index, 0) != 0)
        return BT_ABORT_UNSUPPORTED_ACCESS;
    return value != 0 ? find_mapped(value, is_transmitted, &mapped) : BT_OK;
}
