/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The CAN side without a host: what its rings do when they are full, and an upload in blocks through all of them. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "bt_bytes.h"
#include "bt_canopen.h"

static struct bt_node node;
static struct bt_can can;
static struct bt_can_frame frame;

static void power_up_at(uint32_t first_tick)
{
    struct bt_config config = { 0 };
    config.first_tick = first_tick;
    config.tick_period_ns = 1000000u;
    config.node_id = 5;
    memset(&can, 0x5A, sizeof can); /* what was there does not matter */
    bt_node_init(&node, &config);
    bt_can_init(&can, &node);
    assert(bt_can_transmit(&can, &frame) && frame.id == 0x705 && frame.n == 1 && frame.data[0] == 0);
    assert(!bt_can_transmit(&can, &frame));
}

static void power_up(void)
{
    power_up_at(0);
}

static void tick(void)
{
    bt_node_tick(&node);
    bt_can_tick(&can);
    bt_node_poll(&node);
    bt_can_poll(&can);
}

static void send(uint16_t id, const uint8_t *data, size_t n)
{
    assert(bt_can_receive(&can, id, data, n));
    bt_can_poll(&can);
}

static void request(uint8_t command, uint16_t index, uint8_t sub, uint32_t value)
{
    uint8_t data[8];
    data[0] = command;
    bt_put_u16(data + 1, index);
    data[3] = sub;
    bt_put_u32(data + 4, value);
    send(0x605, data, sizeof data);
}

static void write(enum bt_id id, uint32_t value)
{
    const struct bt_entry *entry = &bt_entries[id];
    request((uint8_t)(0x23u | (4u - entry->size) << 2), entry->index, entry->sub, value);
    assert(bt_can_transmit(&can, &frame) && frame.id == 0x585 && frame.data[0] == 0x60);
}

static void start(void)
{
    const uint8_t data[2] = { BT_NMT_START, 5 };
    send(0, data, sizeof data);
}

static void set_up_tpdo(unsigned number, enum bt_id signal, uint32_t timer_ms)
{
    const unsigned c = number * (BT_ID_tpdo2_cob_id - BT_ID_tpdo1_cob_id);
    const unsigned m = number * (BT_ID_tpdo2_mapping_count - BT_ID_tpdo1_mapping_count);
    write((enum bt_id)(BT_ID_tpdo1_event_timer + c), timer_ms);
    write((enum bt_id)(BT_ID_tpdo1_mapping_1 + m), bt_mapping(&bt_entries[signal]));
    write((enum bt_id)(BT_ID_tpdo1_mapping_count + m), 1);
    write((enum bt_id)(BT_ID_tpdo1_cob_id + c), 0x190u - number);
}

static void check_commands(void)
{
    const uint8_t others[2] = { BT_NMT_START, 6 }, everyones[3] = { BT_NMT_START, 0, 0 };
    power_up();
    send(0, others, 2);
    send(0, everyones, 3);
    assert(node.nmt_state == BT_NMT_PRE_OPERATIONAL);
    send(0, everyones, 2);
    assert(node.nmt_state == BT_NMT_OPERATIONAL);
    assert(!bt_can_receive(&can, 0x605, everyones, 9));
}

static void check_overflow(void)
{
    const uint8_t heartbeat = 5;
    unsigned k;
    power_up();
    for (k = 0; k < BT_CAN_RX_FRAMES; k++)
        assert(bt_can_receive(&can, 0x77F, &heartbeat, 1));
    assert(!bt_can_receive(&can, 0x77F, &heartbeat, 1) && can.rx.lost == 1);
    bt_can_poll(&can);
    for (k = 0; k < BT_CAN_TX_FRAMES + 3u; k++)
        request(0x40, 0x1000, 0, 0);
    assert(can.tx.lost == 3);
    for (k = 0; bt_can_transmit(&can, &frame); k++)
        assert(frame.data[0] == 0x43);
    assert(k == BT_CAN_TX_FRAMES);
}

/* A set of process data that does not fit goes nowhere, and the next set that fits tells so by its number. */
static void check_process_data(void)
{
    unsigned k, number, sequence = 0, sets = 0;
    power_up();
    for (number = 0; number < 2; number++)
        set_up_tpdo(number, BT_ID_stream_sequence, 1);
    start();
    for (k = 0; k < BT_CAN_PDO_FRAMES; k++)
        tick();
    assert(can.pdo.lost == BT_CAN_PDO_FRAMES);
    while (bt_can_transmit(&can, &frame)) {
        assert(frame.id == (sets % 2u ? 0x190u : 0x18Fu) && frame.n == 4); /* the lower identifier first */
        assert(bt_get_u32(frame.data) == 1u + sets / 2u);
        sets++;
    }
    assert(sets == BT_CAN_PDO_FRAMES);
    tick();
    while (bt_can_transmit(&can, &frame))
        sequence = bt_get_u32(frame.data);
    assert(sequence == BT_CAN_PDO_FRAMES + 1u);
    bt_device_trip(&node.device, BT_ERROR_OVERSPEED);
    tick();
    assert(bt_can_transmit(&can, &frame) && frame.id == 0x085);
}

/* 4000 bytes through a transmit ring of 64 frames, which leaves room for a heartbeat at any moment. */
static void check_blocks(void)
{
    const uint8_t begin[8] = { 0xA3 };
    uint8_t last = 0;
    unsigned segments = 0;
    power_up();
    write(BT_ID_capture_channel_1, bt_mapping(&bt_entries[BT_ID_tick]));
    write(BT_ID_capture_rows, 1000);
    write(BT_ID_capture_control, BT_CAPTURE_CONTROL_ARM);
    while (node.device.capture.state != BT_CAPTURE_STATE_COMPLETE) {
        node.device.variables.torque_command += 1.0f;
        tick();
        (void)bt_can_transmit(&can, &frame); /* heartbeats */
    }
    request(0xA4, 0x2042, 0, 127);
    assert(bt_can_transmit(&can, &frame) && frame.data[0] == 0xC6 && bt_get_u32(frame.data + 4) == 4032);
    send(0x605, begin, sizeof begin);
    assert(can.tx.head - can.tx.tail == BT_CAN_TX_FRAMES - BT_CAN_TX_RESERVE);
    while (segments * 7u < 4032u) {
        uint8_t acknowledgement[8] = { 0xA2, 0, 127 };
        while (bt_can_transmit(&can, &frame)) {
            assert(frame.id == 0x585 && (frame.data[0] & 0x7Fu) == acknowledgement[1] + 1u);
            acknowledgement[1]++;
            last = frame.data[0];
            segments++;
            bt_can_poll(&can);
        }
        send(0x605, acknowledgement, sizeof acknowledgement);
    }
    assert(last & 0x80u && segments == 576);
    assert(bt_can_transmit(&can, &frame) && (frame.data[0] & 0xE3u) == 0xC1u);
}

/* Every 10 ticks since power-up, of which 2^32 is no multiple; also when the host sets it up, or starts, after that. */
static void check_wrap(void)
{
    const uint8_t pause[2] = { BT_NMT_ENTER_PRE_OPERATIONAL, 5 };
    uint64_t now = 0xFFFFFFFFu - 94u, expected = now / 10u * 10u + 10u;
    unsigned k, sent = 0;
    power_up_at((uint32_t)now);
    write(BT_ID_producer_heartbeat, 0);
    set_up_tpdo(0, BT_ID_tick, 10);
    start();
    for (k = 0; k < 400; k++) {
        if (k == 200) {
            write((enum bt_id)BT_ID_tpdo1_cob_id, 0x80000190u);
            write((enum bt_id)BT_ID_tpdo1_cob_id, 0x190u);
        }
        if (k == 250)
            send(0, pause, sizeof pause);
        if (k == 275) {
            start();
            expected = now / 10u * 10u + 10u;
        }
        tick();
        now++;
        while (bt_can_transmit(&can, &frame)) {
            assert(frame.id == 0x190u && bt_get_u32(frame.data) == (uint32_t)now && now == expected);
            expected += 10u;
            sent++;
        }
    }
    assert(now > 0x100000000u + 300u && sent == 25 + 13);
}

/* A set of process data that is handed over late, or was out of use for days, goes on at a multiple of its period. */
static void check_late_sets(void)
{
    static struct bt_tpdos tpdos;
    struct bt_can_frame due[BT_TPDOS];
    unsigned k;
    power_up_at(1000);
    set_up_tpdo(0, BT_ID_tick, 10);
    bt_tpdos_renew(&tpdos, &node.device);
    node.device.variables.tick = 1010; /* passed before the set was handed over */
    assert(bt_tpdos_tick(&tpdos, &node.device, false, due) == 0);
    for (k = 1; k <= 20; k++) {
        node.device.variables.tick++;
        assert(bt_tpdos_tick(&tpdos, &node.device, true, due) == (k % 10u == 0));
    }
    node.device.variables.tick += 12345;
    assert(bt_tpdos_tick(&tpdos, &node.device, true, due) == 0);
    node.device.variables.tick += 5;
    assert(bt_tpdos_tick(&tpdos, &node.device, true, due) == 1);
}

static void answered(uint8_t command, uint32_t word)
{
    assert(bt_can_transmit(&can, &frame) && frame.id == 0x585 && frame.data[0] == command);
    assert(bt_get_u32(frame.data + 4) == word);
}

/* Downloads that do not say how long they are (CiA 301, 7.2.4.3.3): the object's own length, or what comes. */
static void check_sizes(void)
{
    static const uint8_t segment[8] = { 0x07, 0x00, 0x00, 0x80, 0x3E }; /* 0.25 */
    const struct bt_entry *const R_s = &bt_entries[BT_ID_R_s];
    power_up();
    request(0x22, 0x6060, 0, 0xAABBCC03u);
    answered(0x60, 0);
    request(0x40, 0x6060, 0, 0);
    answered(0x4F, 3);
    request(0x2E, 0x6040, 0, 0xAABB0006u); /* without s, n counts for nothing */
    answered(0x60, 0);
    request(0x40, 0x6040, 0, 0);
    answered(0x4B, 6);
    request(0x22, R_s->index, R_s->sub, 0x3F000000u);
    answered(0x60, 0);
    request(0x40, R_s->index, R_s->sub, 0);
    answered(0x43, 0x3F000000u);
    request(0x22, 0x6041, 0, 0);
    answered(0x80, BT_ABORT_READ_ONLY);
    request(0x22, 0x5FFF, 0, 0);
    answered(0x80, BT_ABORT_NO_OBJECT);
    request(0x20, R_s->index, R_s->sub, 0xFFFFFFFFu);
    answered(0x60, 0);
    send(0x605, segment, sizeof segment);
    answered(0x20, 0);
    request(0x40, R_s->index, R_s->sub, 0);
    answered(0x43, 0x3E800000u);
}

/* An RPDO with a value that is refused does nothing: not even what stands before that value. */
static void check_refused_process_data(void)
{
    static const uint8_t data[6] = { 15, 0, 0x00, 0x00, 0xC0, 0x7F }; /* enable operation; not a number */
    power_up();
    write(BT_ID_rpdo1_cob_id, 0x80000201u);
    write(BT_ID_rpdo1_mapping_count, 0);
    write(BT_ID_rpdo1_mapping_1, bt_mapping(&bt_entries[BT_ID_controlword]));
    write(BT_ID_rpdo1_mapping_2, bt_mapping(&bt_entries[BT_ID_torque_command]));
    write(BT_ID_rpdo1_mapping_count, 2);
    write(BT_ID_rpdo1_cob_id, 0x201u);
    start();
    write(BT_ID_controlword, 6);
    send(0x201, data, sizeof data);
    assert(node.device.variables.rpdo_dropped == 1);
    assert(node.device.state == BT_STATE_READY_TO_SWITCH_ON && node.device.controlword == 6);
}

/* A frame that is handled before the loss of the link undoes nothing: the interrupt came in the midst of a poll. */
static void check_silence_in_a_poll(void)
{
    static const uint8_t heartbeat = 5, words[3] = { 6, 7, 15 };
    unsigned k;
    power_up();
    write(BT_ID_host_heartbeat, (uint32_t)127 << 16 | 50);
    start();
    send(0x77F, &heartbeat, 1);
    for (k = 0; k < 3; k++)
        write(BT_ID_controlword, words[k]);
    for (k = 0; k < 50; k++)
        bt_node_tick(&node);
    request(0x23, 0x1016, 1, (uint32_t)127 << 16 | 50); /* bt_can_poll, without bt_node_poll */
    assert(node.device.state == BT_STATE_FAULT && node.device.history[0] == BT_ERROR_HEARTBEAT);
}

int main(void)
{
    check_commands();
    check_overflow();
    check_process_data();
    check_blocks();
    check_wrap();
    check_late_sets();
    check_sizes();
    check_refused_process_data();
    check_silence_in_a_poll();
    printf("CAN side: all content\n");
    return 0;
}
