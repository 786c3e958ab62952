/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_dictionary.h"

#include "bt_bytes.h"
#include "bt_sync.h"

#define LIMIT_I8(value) { .i = (value) }
#define LIMIT_I16(value) { .i = (value) }
#define LIMIT_I32(value) { .i = (value) }
#define LIMIT_U8(value) { .u = (value) }
#define LIMIT_U16(value) { .u = (value) }
#define LIMIT_U32(value) { .u = (value) }
#define LIMIT_F32(value) { .f = (value) }
#define LIMIT_STRING(value) { .u = (value) }
#define LIMIT_DOMAIN(value) { .u = (value) }

#define INITIAL_I8(value) { .i = (value) }
#define INITIAL_I16(value) { .i = (value) }
#define INITIAL_I32(value) { .i = (value) }
#define INITIAL_U8(value) { .u = (value) }
#define INITIAL_U16(value) { .u = (value) }
#define INITIAL_U32(value) { .u = (value) }
#define INITIAL_F32(value) { .f = (value) }
#define INITIAL_STRING(value) { .text = (value) }
#define INITIAL_DOMAIN(value) { .u = (value) }

#define OFFSET(name) ((uint16_t)offsetof(struct bt_variables, name))
#define OFFSET_I8(name) OFFSET(name)
#define OFFSET_I16(name) OFFSET(name)
#define OFFSET_I32(name) OFFSET(name)
#define OFFSET_U8(name) OFFSET(name)
#define OFFSET_U16(name) OFFSET(name)
#define OFFSET_U32(name) OFFSET(name)
#define OFFSET_F32(name) OFFSET(name)
#define OFFSET_STRING(name) 0u
#define OFFSET_DOMAIN(name) 0u

#define ROW(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, low, high, initial) \
    { (index), \
      (sub), \
      BT_TYPE_##TYPE, \
      BT_SIZE_##TYPE, \
      BT_ACCESS_##ACCESS, \
      BT_ROLE_##ROLE, \
      (enabled_write) * BT_FLAG_ENABLED_WRITE | (add_node_id) * BT_FLAG_ADD_NODE_ID, \
      OFFSET_##TYPE(name), \
      LIMIT_##TYPE(low), \
      LIMIT_##TYPE(high), \
      INITIAL_##TYPE(initial) },

const struct bt_entry bt_entries[BT_ENTRY_COUNT] = { BT_ENTRIES(ROW) };

/* The values of enumerations; all fit 16 bits. */
struct value {
    uint16_t id;
    int16_t value;
};
#define VALUE(name, value) { BT_ID_##name, (value) },
static const struct value values[BT_VALUE_COUNT] = { BT_VALUES(VALUE) };

uint32_t bt_find(uint16_t index, uint8_t sub, enum bt_id *id)
{
    const uint32_t wanted = (uint32_t)index << 8 | sub;
    uint32_t low = 0, high = BT_ENTRY_COUNT;
    while (low < high) {
        const uint32_t middle = (low + high) / 2u;
        if (((uint32_t)bt_entries[middle].index << 8 | bt_entries[middle].sub) < wanted)
            low = middle + 1u;
        else
            high = middle;
    }
    *id = (enum bt_id)low;
    if (low < BT_ENTRY_COUNT && bt_entries[low].index == index) {
        if (bt_entries[low].sub == sub)
            return BT_OK;
        *id = BT_ID_NONE;
        return BT_ABORT_NO_SUB_INDEX;
    }
    *id = BT_ID_NONE;
    return low > 0 && bt_entries[low - 1u].index == index ? BT_ABORT_NO_SUB_INDEX : BT_ABORT_NO_OBJECT;
}

uint32_t bt_mapping(const struct bt_entry *entry)
{
    return (uint32_t)entry->index << 16 | (uint32_t)entry->sub << 8 | entry->size * 8u;
}

bool bt_is_mappable(const struct bt_entry *entry)
{
    return entry->size > 0 && (entry->role == BT_ROLE_SIGNAL || entry->role == BT_ROLE_COMMAND ||
                               (entry->role == BT_ROLE_STATUS && entry->index >= 0x6000u));
}

/* Whether the entry is no enumeration, or has this value. */
static bool is_allowed(enum bt_id id, int32_t number)
{
    bool enumerated = false;
    uint32_t k;
    for (k = 0; k < BT_VALUE_COUNT; k++) {
        if (values[k].id == id) {
            if (values[k].value == number)
                return true;
            enumerated = true;
        }
    }
    return !enumerated;
}

static union bt_number number_of(const struct bt_entry *entry, const uint8_t *data)
{
    union bt_number number;
    switch (entry->type) {
    case BT_TYPE_I8:
        number.i = (int8_t)data[0];
        break;
    case BT_TYPE_U8:
        number.u = data[0];
        break;
    case BT_TYPE_I16:
        number.i = (int16_t)bt_get_u16(data);
        break;
    case BT_TYPE_U16:
        number.u = bt_get_u16(data);
        break;
    default:
        number.u = bt_get_u32(data);
        break;
    }
    return number;
}

static uint32_t check_limits(const struct bt_entry *entry, union bt_number number)
{
    bool high, low;
    switch (entry->type) {
    case BT_TYPE_I8:
    case BT_TYPE_I16:
    case BT_TYPE_I32:
        high = number.i > entry->high.i;
        low = number.i < entry->low.i;
        break;
    case BT_TYPE_F32:
        high = number.f > entry->high.f;
        low = number.f < entry->low.f;
        break;
    default:
        high = number.u > entry->high.u;
        low = number.u < entry->low.u;
        break;
    }
    return high ? BT_ABORT_VALUE_HIGH : low ? BT_ABORT_VALUE_LOW : BT_OK;
}

uint32_t bt_decode(enum bt_id id, const uint8_t *data, size_t n, union bt_number *number)
{
    const struct bt_entry *entry = &bt_entries[id];
    if (entry->size == 0)
        return BT_ABORT_READ_ONLY;
    if (n != entry->size)
        return n > entry->size ? BT_ABORT_LENGTH_HIGH : BT_ABORT_LENGTH_LOW;
    *number = number_of(entry, data);
    if (entry->type == BT_TYPE_F32) {
        if (!bt_is_finite(number->f))
            return BT_ABORT_VALUE;
    } else if (!is_allowed(id, number->i)) {
        return BT_ABORT_VALUE;
    }
    return check_limits(entry, *number);
}

size_t bt_encode(enum bt_id id, union bt_number number, uint8_t data[4])
{
    bt_put_u32(data, number.u); /* two's complement: the low bytes of an int32_t are those of the shorter types */
    return bt_entries[id].size;
}

/* Through pointers of each one's own type: an access of one instruction, and no other order than the written one. */
union bt_number bt_load(const struct bt_variables *variables, enum bt_id id)
{
    const struct bt_entry *entry = &bt_entries[id];
    const volatile void *at = (const volatile uint8_t *)variables + entry->offset;
    union bt_number number = { 0 };
    switch (entry->type) {
    case BT_TYPE_I8:
        number.i = *(const volatile int8_t *)at;
        break;
    case BT_TYPE_U8:
        number.u = *(const volatile uint8_t *)at;
        break;
    case BT_TYPE_I16:
        number.i = *(const volatile int16_t *)at;
        break;
    case BT_TYPE_U16:
        number.u = *(const volatile uint16_t *)at;
        break;
    case BT_TYPE_I32:
        number.i = *(const volatile int32_t *)at;
        break;
    case BT_TYPE_U32:
        number.u = *(const volatile uint32_t *)at;
        break;
    case BT_TYPE_F32:
        number.f = *(const volatile float *)at;
        break;
    default:
        break;
    }
    return number;
}

void bt_store(struct bt_variables *variables, enum bt_id id, union bt_number number)
{
    const struct bt_entry *entry = &bt_entries[id];
    volatile void *at = (volatile uint8_t *)variables + entry->offset;
    switch (entry->type) {
    case BT_TYPE_I8:
        *(volatile int8_t *)at = (int8_t)number.i;
        break;
    case BT_TYPE_U8:
        *(volatile uint8_t *)at = (uint8_t)number.u;
        break;
    case BT_TYPE_I16:
        *(volatile int16_t *)at = (int16_t)number.i;
        break;
    case BT_TYPE_U16:
        *(volatile uint16_t *)at = (uint16_t)number.u;
        break;
    case BT_TYPE_I32:
        *(volatile int32_t *)at = number.i;
        break;
    case BT_TYPE_U32:
        *(volatile uint32_t *)at = number.u;
        break;
    case BT_TYPE_F32:
        *(volatile float *)at = number.f;
        break;
    default:
        break;
    }
}

static union bt_number default_of(const struct bt_entry *entry, uint8_t node_id)
{
    union bt_number number;
    number.u = entry->initial.u;
    if (entry->type == BT_TYPE_F32)
        number.f = entry->initial.f;
    if (entry->flags & BT_FLAG_ADD_NODE_ID)
        number.u += node_id;
    return number;
}

/* Each is stored once: control never sees the default of a parameter that was kept. */
void bt_set_defaults(struct bt_variables *variables, uint8_t node_id, uint16_t first, uint16_t last,
                     const uint32_t *parameters)
{
    uint32_t id;
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        const struct bt_entry *entry = &bt_entries[id];
        union bt_number number = default_of(entry, node_id);
        if (entry->role == BT_ROLE_PARAMETER && parameters != NULL)
            number.u = *parameters++;
        if (entry->size == 0 || entry->role == BT_ROLE_SIGNAL || entry->index < first || entry->index > last)
            continue;
        BT_LOCK();
        bt_store(variables, (enum bt_id)id, number);
        BT_UNLOCK();
    }
}

void bt_set_parameters(struct bt_variables *variables, const uint32_t *parameters)
{
    uint32_t id;
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        const struct bt_entry *entry = &bt_entries[id];
        union bt_number number = default_of(entry, 0);
        if (entry->role != BT_ROLE_PARAMETER)
            continue;
        if (parameters != NULL)
            number.u = *parameters++;
        BT_LOCK();
        bt_store(variables, (enum bt_id)id, number);
        BT_UNLOCK();
    }
}
