/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The object dictionary: a table from drive_objects.h, and a variable for every number in it.
 *
 * The firmware's control reads its parameters and commands from these variables and writes its signals to them. A
 * variable of up to 32 bits that is aligned is read and written whole; the main loop does so with the lock held. */
#ifndef BT_DICTIONARY_H
#define BT_DICTIONARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bt_abort.h"
#include "drive_objects.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_MEMBER_I8(name) int8_t name;
#define BT_MEMBER_U8(name) uint8_t name;
#define BT_MEMBER_I16(name) int16_t name;
#define BT_MEMBER_U16(name) uint16_t name;
#define BT_MEMBER_I32(name) int32_t name;
#define BT_MEMBER_U32(name) uint32_t name;
#define BT_MEMBER_F32(name) float name;
#define BT_MEMBER_STRING(name)
#define BT_MEMBER_DOMAIN(name)
#define BT_MEMBER(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, low, high, initial) \
    BT_MEMBER_##TYPE(name)

/* Every number of the dictionary by its name there, raw. */
struct bt_variables {
    BT_ENTRIES(BT_MEMBER)
};

#define BT_NUMBER_OF(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, low, high, initial) \
    BT_ID_##name,

/* Every entry by its place in the table. */
enum bt_id { BT_ENTRIES(BT_NUMBER_OF) BT_ID_NONE };

/* A number as its entry has it: `i` for I8 to I32, `u` for U8 to U32, `f` for F32. `text` is a string's. */
union bt_number {
    uint32_t u;
    int32_t i;
    float f;
};

union bt_initial {
    uint32_t u;
    int32_t i;
    float f;
    const char *text;
};

#define BT_FLAG_ENABLED_WRITE 1u /* may be written while the power stage is on */
#define BT_FLAG_ADD_NODE_ID 2u

struct bt_entry {
    uint16_t index;
    uint8_t sub;
    uint8_t type;
    uint8_t size; /* bytes; 0 of strings and domains */
    uint8_t access;
    uint8_t role;
    uint8_t flags;
    uint16_t offset; /* in struct bt_variables */
    union bt_number low, high;
    union bt_initial initial;
};

extern const struct bt_entry bt_entries[BT_ENTRY_COUNT];

/* Place of an entry: BT_OK, or BT_ABORT_NO_OBJECT or BT_ABORT_NO_SUB_INDEX. */
uint32_t bt_find(uint16_t index, uint8_t sub, enum bt_id *id);

/* The entry as a mapping names it: index << 16 | sub-index << 8 | bits. */
uint32_t bt_mapping(const struct bt_entry *entry);

/* Whether process data may carry it: signals, commands, and what CiA 402 tells of the drive's state. */
bool bt_is_mappable(const struct bt_entry *entry);

/* The number that bytes state, if it is one that the entry may have: BT_OK or an abort code. Looks at length, then
 * finiteness, enumeration and limits; at neither access nor state. */
uint32_t bt_decode(enum bt_id id, const uint8_t *data, size_t n, union bt_number *number);

/* Little-endian bytes of a number; how many. */
size_t bt_encode(enum bt_id id, union bt_number number, uint8_t data[4]);

/* In the control interrupt, or with the lock held; the main loop also reads without it what it alone writes. */
union bt_number bt_load(const struct bt_variables *variables, enum bt_id id);
void bt_store(struct bt_variables *variables, enum bt_id id, union bt_number number);

/* Give every variable of the objects `first` to `last` that is no signal its default; a parameter the value that was
 * kept, unless `parameters`, which has all of them in the order of the table, is NULL. */
void bt_set_defaults(struct bt_variables *variables, uint8_t node_id, uint16_t first, uint16_t last,
                     const uint32_t *parameters);

/* Give the parameters alone the values that were kept, or their defaults. */
void bt_set_parameters(struct bt_variables *variables, const uint32_t *parameters);

#ifdef __cplusplus
}
#endif

#endif
