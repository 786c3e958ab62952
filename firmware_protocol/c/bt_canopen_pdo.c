/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_canopen_pdo.h"

#include "bt_bytes.h"
#include "bt_sync.h"

#define INVALID 0x80000000u
#define CAN_ID 0x7FFu
#define COUNTING_TPDO 0u

static uint32_t load(const struct bt_variables *variables, unsigned index, unsigned sub)
{
    enum bt_id id;
    return bt_find((uint16_t)index, (uint8_t)sub, &id) == BT_OK ? bt_load(variables, id).u : 0;
}

/* The entries of a PDO that is in use, so that its mapping has been checked; how many. */
static uint8_t entries(const struct bt_variables *variables, unsigned mapping_index, uint16_t *ids)
{
    const uint8_t count = (uint8_t)load(variables, mapping_index, 0);
    uint8_t k;
    for (k = 0; k < count && k < BT_PDO_ENTRIES; k++) {
        const uint32_t mapping = load(variables, mapping_index, k + 1u);
        enum bt_id id;
        if (bt_find((uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), &id) != BT_OK)
            break;
        ids[k] = (uint16_t)id;
    }
    return k;
}

/* ---- to the host ---------------------------------------------------------------------------------------- */

void bt_tpdos_renew(struct bt_tpdos *tpdos, const struct bt_device *device)
{
    const struct bt_variables *variables = &device->variables;
    const uint32_t tick_period_ns = device->config.tick_period_ns;
    const uint8_t *objects = (const uint8_t *)variables + BT_TPDO_FIRST;
    const uint8_t next = tpdos->active ^ 1u;
    struct bt_tpdo *pdos = tpdos->sets[next].pdos;
    uint64_t present;
    unsigned number;
    uint8_t count = 0;
    if (memcmp(tpdos->seen, objects, BT_TPDO_BYTES) == 0)
        return;
    present = bt_device_ticks(device);
    memcpy(tpdos->seen, objects, BT_TPDO_BYTES);
    for (number = 0; number < BT_TPDOS; number++) {
        const uint32_t cob_id = load(variables, 0x1800u + number, 1);
        const uint64_t timer_ns = (uint64_t)load(variables, 0x1800u + number, 5) * 1000000u;
        struct bt_tpdo pdo;
        uint8_t place;
        pdo.ticks = (uint32_t)((timer_ns + tick_period_ns / 2u) / tick_period_ns);
        if (cob_id & INVALID || pdo.ticks == 0)
            continue;
        pdo.due = (uint32_t)((present / pdo.ticks + 1u) * pdo.ticks);
        pdo.can_id = cob_id & CAN_ID;
        pdo.is_first = number == COUNTING_TPDO;
        pdo.count = entries(variables, 0x1A00u + number, pdo.ids);
        for (place = count++; place > 0 && pdos[place - 1u].can_id > pdo.can_id; place--)
            pdos[place] = pdos[place - 1u];
        pdos[place] = pdo;
    }
    tpdos->sets[next].count = count;
    BT_LOCK();
    tpdos->active = next;
    BT_UNLOCK();
}

/* Little-endian bytes of an entry; how many. */
static size_t sample(const struct bt_device *device, enum bt_id id, uint8_t *data)
{
    union bt_number number;
    uint8_t bytes[4];
    (void)bt_number(device, id, &number);
    (void)bt_encode(id, number, bytes);
    memcpy(data, bytes, bt_entries[id].size);
    return bt_entries[id].size;
}

/* Whether it is to be sent in this tick. A set that was handed over late goes on at its next multiple. */
static bool falls_due(struct bt_tpdo *pdo, uint32_t tick)
{
    const uint32_t late = tick - pdo->due;
    uint32_t past;
    if (late > INT32_MAX)
        return false;
    past = late % pdo->ticks;
    pdo->due = tick - past + pdo->ticks;
    return past == 0;
}

size_t bt_tpdos_tick(struct bt_tpdos *tpdos, struct bt_device *device, bool operational, struct bt_can_frame *frames)
{
    struct bt_tpdo *pdos = tpdos->sets[tpdos->active].pdos;
    const unsigned count = tpdos->sets[tpdos->active].count;
    bool due[BT_TPDOS];
    size_t n = 0;
    unsigned number, k;
    for (number = 0; number < count; number++) {
        due[number] = falls_due(&pdos[number], device->variables.tick) && operational;
        if (due[number] && pdos[number].is_first)
            device->variables.stream_sequence++;
    }
    for (number = 0; number < count; number++) {
        const struct bt_tpdo *pdo = &pdos[number];
        struct bt_can_frame *frame = &frames[n];
        if (!due[number])
            continue;
        frame->id = pdo->can_id;
        frame->n = 0;
        for (k = 0; k < pdo->count; k++)
            frame->n = (uint8_t)(frame->n + sample(device, (enum bt_id)pdo->ids[k], frame->data + frame->n));
        n++;
    }
    return n;
}

/* ---- from the host -------------------------------------------------------------------------------------- */

static bool may_write_all(const struct bt_device *device, const uint16_t *ids, uint8_t count, const uint8_t *data)
{
    uint8_t k;
    for (k = 0; k < count; k++) {
        if (bt_check(device, (enum bt_id)ids[k], data, bt_entries[ids[k]].size) != BT_OK)
            return false;
        data += bt_entries[ids[k]].size;
    }
    return true;
}

static uint32_t write(struct bt_device *device, uint16_t id, const uint8_t *data)
{
    return bt_write(device, bt_entries[id].index, bt_entries[id].sub, data, bt_entries[id].size);
}

/* None is written unless all may be; one that only those before it made impossible gives them their old values. */
static bool write_all(struct bt_device *device, const uint16_t *ids, uint8_t count, const uint8_t *data)
{
    struct bt_value before[BT_PDO_ENTRIES];
    uint8_t k;
    if (!may_write_all(device, ids, count, data))
        return false;
    for (k = 0; k < count; k++) {
        if (bt_read(device, bt_entries[ids[k]].index, bt_entries[ids[k]].sub, &before[k]) != BT_OK)
            return false;
    }
    for (k = 0; k < count && write(device, ids[k], data) == BT_OK; k++)
        data += bt_entries[ids[k]].size;
    if (k == count)
        return true;
    while (k-- > 0) {
        if (write(device, ids[k], before[k].number) != BT_OK)
            break;
    }
    return false;
}

static bool take(struct bt_node *node, const uint16_t *ids, uint8_t count, const uint8_t *data)
{
    /* The host's own mapping: the control interrupt must not see one of them without the other. */
    if (count == 2 && ids[0] == BT_ID_torque_command && ids[1] == BT_ID_omega_m_command)
        return bt_node_take_setpoint(node, data, data + 4);
    if (!write_all(&node->device, ids, count, data))
        return false;
    bt_watchdog_feed(&node->device.watchdog, &node->device.variables.tick);
    return true;
}

void bt_rpdo_take(struct bt_node *node, uint16_t can_id, const uint8_t *data, size_t n)
{
    struct bt_variables *variables = &node->device.variables;
    unsigned number = BT_RPDOS;
    while (number-- > 0) {
        const uint32_t cob_id = load(variables, 0x1400u + number, 1);
        uint16_t ids[BT_PDO_ENTRIES];
        size_t length = 0;
        uint8_t count, k;
        if (cob_id & INVALID || (cob_id & CAN_ID) != can_id)
            continue;
        count = entries(variables, 0x1600u + number, ids);
        for (k = 0; k < count; k++)
            length += bt_entries[ids[k]].size;
        if (n < length || !take(node, ids, count, data))
            bt_device_count(&variables->rpdo_dropped, 1);
        return;
    }
}
