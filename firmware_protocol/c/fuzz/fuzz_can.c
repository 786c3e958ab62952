/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Hostile frames for libFuzzer. What must hold whatever comes: no access out of bounds (the sanitizers see to it), a
 * request that is answered by an abort changes no variable, every number is within the limits of its entry, and what
 * the drive sends are frames that can be. */
#undef NDEBUG
#include <assert.h>
#include <stdlib.h>

#include "bt_bytes.h"
#include "bt_canopen.h"

#define NODE 1u

struct input {
    const uint8_t *data;
    size_t n;
};

static struct bt_node node;
static struct bt_can can;

static uint8_t take(struct input *input)
{
    if (input->n == 0)
        return 0;
    input->n--;
    return *input->data++;
}

static void check_frame(const struct bt_can_frame *frame)
{
    assert(frame->n <= 8);
    assert(frame->id == 0x080u + NODE || frame->id == 0x580u + NODE || frame->id == 0x700u + NODE ||
           (frame->id >= 0x181u && frame->id <= 0x57Fu));
    assert(frame->id != 0x580u + NODE || frame->n == 8);
}

static void hear_all(void)
{
    struct bt_can_frame frame;
    while (bt_can_transmit(&can, &frame)) {
        check_frame(&frame);
        bt_can_poll(&can);
    }
}

static void check_numbers(void)
{
    unsigned id;
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        const struct bt_entry *entry = &bt_entries[id];
        const union bt_number number = bt_load(&node.device.variables, (enum bt_id)id);
        if (entry->size == 0 || (entry->access != BT_ACCESS_RW && entry->access != BT_ACCESS_WO))
            continue;
        if (entry->type == BT_TYPE_F32)
            assert(bt_is_finite(number.f) && number.f >= entry->low.f && number.f <= entry->high.f);
        else if (entry->type == BT_TYPE_I8 || entry->type == BT_TYPE_I16 || entry->type == BT_TYPE_I32)
            assert(number.i >= entry->low.i && number.i <= entry->high.i);
        else
            assert(number.u >= entry->low.u && number.u <= entry->high.u);
    }
}

/* Bytes of a request that are an object of the table, or near one. */
static void take_place(struct input *input, uint8_t *data)
{
    const unsigned choice = take(input) | (unsigned)take(input) << 8;
    const struct bt_entry *entry = &bt_entries[choice % BT_ENTRY_COUNT];
    bt_put_u16(data + 1, entry->index);
    data[3] = choice >= 0xE000u ? take(input) : entry->sub;
}

static void request(struct input *input)
{
    static struct bt_variables before;
    struct bt_can_frame frame = { 0x600u + NODE, 8, { 0 } };
    const uint8_t kind = take(input);
    unsigned k;
    frame.data[0] = take(input);
    for (k = 1; k < 8; k++)
        frame.data[k] = kind & 1u ? take(input) : 0;
    if (kind & 2u)
        take_place(input, frame.data);
    if (kind & 4u)
        bt_put_u32(frame.data + 4, bt_mapping(&bt_entries[take(input) % BT_ENTRY_COUNT]));
    hear_all();
    before = node.device.variables;
    if (!bt_can_receive(&can, frame.id, frame.data, frame.n))
        return;
    bt_can_poll(&can);
    if (bt_can_transmit(&can, &frame)) {
        check_frame(&frame);
        if (frame.id == 0x580u + NODE && frame.data[0] == 0x80u)
            assert(memcmp(&before, &node.device.variables, sizeof before) == 0);
    }
}

/* An entry that a PDO may have both ways, or any. */
static enum bt_id take_mapped(struct input *input)
{
    static const enum bt_id both_ways[] = { BT_ID_torque_command, BT_ID_omega_m_command, BT_ID_psi_s_command,
                                            BT_ID_controlword,    BT_ID_target_torque,   BT_ID_mode_of_operation };
    const unsigned choice = take(input) | (unsigned)take(input) << 8;
    return choice & 0x8000u ? (enum bt_id)(choice % BT_ENTRY_COUNT)
                            : both_ways[choice % (sizeof both_ways / sizeof both_ways[0])];
}

/* The writes that put a PDO into use: what it may not have is refused. */
static void set_up_pdo(struct input *input)
{
    const unsigned number = take(input) % (BT_TPDOS + BT_RPDOS), count = take(input) % 6u;
    const unsigned index = number < BT_TPDOS ? 0x1800u + number : 0x1400u + number - BT_TPDOS;
    const uint32_t can_id = 0x180u + take(input);
    uint8_t raw[4];
    unsigned k;
    bt_put_u32(raw, 0x80000000u | can_id);
    (void)bt_write(&node.device, (uint16_t)index, 1, raw, 4);
    bt_put_u32(raw, take(input) % 4u);
    (void)bt_write(&node.device, (uint16_t)index, 5, raw, 2);
    bt_put_u32(raw, 0);
    (void)bt_write(&node.device, (uint16_t)(index + 0x200u), 0, raw, 1);
    for (k = 1; k <= count; k++) {
        bt_put_u32(raw, bt_mapping(&bt_entries[take_mapped(input)]));
        (void)bt_write(&node.device, (uint16_t)(index + 0x200u), (uint8_t)k, raw, 4);
    }
    raw[0] = (uint8_t)count;
    (void)bt_write(&node.device, (uint16_t)(index + 0x200u), 0, raw, 1);
    bt_put_u32(raw, can_id);
    (void)bt_write(&node.device, (uint16_t)index, 1, raw, 4);
}

/* A frame of an RPDO that is in use. */
static void send_process_data(struct input *input)
{
    uint8_t data[8];
    unsigned k;
    for (k = 0; k < sizeof data; k++)
        data[k] = take(input);
    node.nmt_state = BT_NMT_OPERATIONAL;
    (void)bt_can_receive(&can, (uint16_t)(node.device.variables.rpdo1_cob_id & 0x7FFu), data, take(input) % 9u);
    (void)bt_can_receive(&can, (uint16_t)(node.device.variables.rpdo2_cob_id & 0x7FFu), data, sizeof data);
}

static void set(enum bt_id id, uint32_t value)
{
    uint8_t raw[4];
    bt_put_u32(raw, value);
    (void)bt_write(&node.device, bt_entries[id].index, bt_entries[id].sub, raw, bt_entries[id].size);
}

static void capture(struct input *input)
{
    set(BT_ID_capture_channel_1, bt_mapping(&bt_entries[BT_ID_tick]));
    set(BT_ID_capture_channel_2, take(input) & 1u ? bt_mapping(&bt_entries[BT_ID_torque]) : 0);
    set(BT_ID_capture_rows, take(input));
    set(BT_ID_capture_pretrigger, 0);
    set(BT_ID_capture_trigger, BT_CAPTURE_TRIGGER_IMMEDIATE);
    set(BT_ID_capture_control, BT_CAPTURE_CONTROL_ARM);
}

static void send_request(uint8_t command, uint8_t a, uint8_t b)
{
    uint8_t data[8] = { command, a, b };
    hear_all();
    (void)bt_can_receive(&can, 0x600u + NODE, data, sizeof data);
    bt_can_poll(&can);
}

/* A string or a capture in blocks, by a client that says what it likes of what has arrived. */
static void upload_blocks(struct input *input)
{
    uint8_t begin[8] = { 0xA4 };
    unsigned k;
    bt_put_u16(begin + 1, take(input) & 1u ? bt_entries[BT_ID_capture_data].index
                                           : bt_entries[BT_ID_device_name].index);
    begin[4] = take(input);
    hear_all();
    (void)bt_can_receive(&can, 0x600u + NODE, begin, sizeof begin);
    bt_can_poll(&can);
    send_request(0xA3, 0, 0);
    for (k = take(input) % 16u; k > 0; k--) {
        const uint8_t in_order = take(input);
        send_request(0xA2, in_order, take(input));
    }
}

static void tick(void)
{
    bt_node_tick(&node);
    bt_can_tick(&can);
}

static void step(struct input *input)
{
    uint8_t data[8];
    uint16_t id;
    unsigned k;
    switch (take(input) % 10u) {
    case 0: /* anything, whoever's */
        id = (uint16_t)((take(input) | (unsigned)take(input) << 8) & 0x7FFu);
        for (k = 0; k < 8; k++)
            data[k] = take(input);
        (void)bt_can_receive(&can, id, data, take(input) % 12u);
        break;
    case 1:
    case 2:
        request(input);
        break;
    case 3:
        set_up_pdo(input);
        break;
    case 4:
        for (k = take(input); k > 0; k--)
            tick();
        break;
    case 5:
        data[0] = take(input) & 0x87u;
        data[1] = take(input) & 1u;
        (void)bt_can_receive(&can, 0, data, 2);
        break;
    case 6:
        capture(input);
        break;
    case 7:
        send_process_data(input);
        break;
    case 8:
        upload_blocks(input);
        break;
    default:
        if (take(input) & 3u)
            hear_all();
        else
            bt_device_trip(&node.device, take(input));
        break;
    }
    bt_node_poll(&node);
    bt_can_poll(&can);
    assert(can.tx.head - can.tx.tail <= BT_CAN_TX_FRAMES && can.pdo.head - can.pdo.tail <= BT_CAN_PDO_FRAMES);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    struct bt_config config = { 0 };
    struct input input = { data, n };
    config.tick_period_ns = 500000u;
    config.node_id = NODE;
    bt_node_init(&node, &config);
    bt_can_init(&can, &node);
    while (input.n > 0)
        step(&input);
    hear_all();
    check_numbers();
    return 0;
}
