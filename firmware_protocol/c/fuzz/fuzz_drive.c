/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Hostile input for libFuzzer: bytes, damaged and whole frames, accesses anywhere. What must hold whatever comes:
 * no access out of bounds (the sanitizers see to it), a refused write and a damaged frame change no variable, a
 * write that was taken is within the limits of its entry, and all that the drive sends is whole. */
#undef NDEBUG
#include <assert.h>
#include <stdlib.h>

#include "bt_bytes.h"
#include "bt_crc.h"
#include "host.h"

struct input {
    const uint8_t *data;
    size_t n;
};

static struct bt_drive drive;

static uint8_t take(struct input *input)
{
    if (input->n == 0)
        return 0;
    input->n--;
    return *input->data++;
}

static size_t take_some(struct input *input, uint8_t *to, size_t most)
{
    size_t n = take(input), k;
    if (n > most)
        n = most;
    for (k = 0; k < n; k++)
        to[k] = take(input);
    return n;
}

static void hear_all(void)
{
    uint8_t payload[BT_MAX_REPLY];
    while (host_hear(&drive, payload, sizeof payload) > 0) {
    }
}

/* An entry of the table, or a place beside it. */
static void take_place(struct input *input, uint16_t *index, uint8_t *sub)
{
    const unsigned choice = take(input) | (unsigned)take(input) << 8;
    const struct bt_entry *entry = &bt_entries[choice % BT_ENTRY_COUNT];
    *index = entry->index;
    *sub = entry->sub;
    if (choice >= 0xC000u) {
        *sub = take(input);
        if (choice >= 0xE000u)
            *index = (uint16_t)choice;
    }
}

static void check_number(enum bt_id id)
{
    const struct bt_entry *entry = &bt_entries[id];
    const union bt_number number = bt_load(&drive.node.device.variables, id);
    switch (entry->type) {
    case BT_TYPE_F32:
        assert(bt_is_finite(number.f) && number.f >= entry->low.f && number.f <= entry->high.f);
        break;
    case BT_TYPE_I8:
    case BT_TYPE_I16:
    case BT_TYPE_I32:
        assert(number.i >= entry->low.i && number.i <= entry->high.i);
        break;
    default:
        assert(number.u >= entry->low.u && number.u <= entry->high.u);
        break;
    }
}

static void write_somewhere(struct input *input)
{
    static struct bt_variables before;
    static struct bt_device device;
    uint8_t data[16];
    uint16_t index;
    uint8_t sub;
    enum bt_id id;
    size_t n;
    uint32_t status;
    take_place(input, &index, &sub);
    n = take_some(input, data, sizeof data);
    if (bt_find(index, sub, &id) == BT_OK && n > 0 && (n & 8u))
        n = bt_entries[id].size;
    before = drive.node.device.variables;
    memcpy(&device.history, &drive.node.device.history, sizeof device.history);
    device.state = drive.node.device.state;
    status = bt_write(&drive.node.device, index, sub, data, n);
    if (status != BT_OK) {
        assert(memcmp(&before, &drive.node.device.variables, sizeof before) == 0);
        assert(memcmp(&device.history, &drive.node.device.history, sizeof device.history) == 0);
        assert(device.state == drive.node.device.state);
        return;
    }
    assert(bt_find(index, sub, &id) == BT_OK && bt_entries[id].size == n);
    assert(bt_entries[id].access == BT_ACCESS_RW || bt_entries[id].access == BT_ACCESS_WO);
    check_number(id);
}

static void send_damaged(struct input *input)
{
    static uint8_t frame[2u * BT_FRAME_LONGEST(BT_MAX_REQUEST)], data[2048];
    static struct bt_variables before;
    uint8_t payload[BT_MAX_REQUEST];
    struct bt_ring line;
    size_t n = take_some(input, payload, sizeof payload);
    size_t at;
    hear_all();
    host_send(&drive, (const uint8_t *)"\x13\x00", 2); /* ends whatever had begun */
    bt_ring_init(&line, data, sizeof data);
    if (n == 0 || !bt_frame_send(&line, payload, n, 0))
        return;
    n = bt_ring_get(&line, frame, sizeof frame);
    at = 1u + take(input) % (n - 2u);
    if (take(input) & 1u) {
        memmove(frame + at, frame + at + 1, n - at - 1u); /* a byte lost */
        n--;
    } else {
        frame[at] ^= (uint8_t)(1u << take(input) % 8u);
    }
    before = drive.node.device.variables;
    bt_receive(&drive, frame, n);
    bt_poll(&drive);
    before.serial_dropped = drive.node.device.variables.serial_dropped;
    assert(memcmp(&before, &drive.node.device.variables, sizeof before) == 0);
}

static void send_request(struct input *input)
{
    uint8_t payload[256] = { 0 }; /* may be longer than the drive takes */
    uint16_t index;
    uint8_t sub;
    size_t n = 5, k;
    payload[0] = (uint8_t)(1u + take(input) % 7u);
    payload[1] = take(input);
    switch (payload[0]) {
    case BT_CHUNKS:
        payload[2] = take(input) & 0x80u ? take(input) : drive.serial.upload.number;
        for (k = 3; k < 9; k++)
            payload[k] = k < 6 ? take(input) & 7u : take(input) & 3u ? 0 : take(input);
        n = 9;
        break;
    case BT_STREAM:
        payload[2] = take(input);
        payload[4] = take(input);
        payload[5] = take(input) & 1u;
        payload[6] = take(input) % 20u;
        for (k = 0; k < payload[6]; k++) {
            take_place(input, &index, &sub);
            bt_put_u32(payload + 7 + 4 * k, (uint32_t)index << 16 | (uint32_t)sub << 8 | 32u);
            if (payload[5])
                bt_put_u32(payload + 7 + 4u * payload[6] + 4 * k, bt_word_of((float)take(input) - 1.0f));
        }
        n = 7u + (payload[5] ? 8u : 4u) * payload[6];
        break;
    default:
        take_place(input, &index, &sub);
        bt_put_u16(payload + 2, index);
        payload[4] = sub;
        if (payload[0] == BT_WRITE)
            n += take_some(input, payload + 5, 16);
        break;
    }
    host_send(&drive, payload, n);
}

static void step(struct input *input)
{
    struct bt_variables *variables = bt_variables(&drive);
    uint8_t bytes[256];
    size_t n;
    unsigned k;
    switch (take(input) % 9u) {
    case 0:
        n = take_some(input, bytes, sizeof bytes);
        bt_receive(&drive, bytes, n);
        break;
    case 1:
        n = take_some(input, bytes, sizeof bytes);
        if (n > 0)
            host_send(&drive, bytes, n);
        break;
    case 2:
    case 3:
        write_somewhere(input);
        break;
    case 4:
        send_request(input);
        break;
    case 5:
        send_damaged(input);
        break;
    case 6:
        variables->torque = bt_float_of((uint32_t)take(input) << 24 | take(input));
        for (k = take(input); k > 0; k--)
            bt_tick(&drive);
        break;
    case 7:
        host_nmt(&drive, (uint8_t)(take(input) & 0x87u));
        break;
    default:
        if (take(input) & 1u)
            bt_trip(&drive, take(input));
        else
            hear_all();
        break;
    }
    bt_poll(&drive);
    assert(bt_ring_waiting(&drive.serial.tx) <= BT_TX_BYTES && bt_ring_waiting(&drive.serial.rx) <= BT_RX_BYTES);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    struct bt_config config = { 0 };
    struct input input = { data, n };
    config.tick_period_ns = 100000u;
    config.node_id = 1;
    bt_init(&drive, &config);
    while (input.n > 0)
        step(&input);
    hear_all();
    return 0;
}
