/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The tick wraps at 2^32: streams, captures, supervision and heartbeats go on as if it did not. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "check.h"
#include "host.h"

#define BEFORE 1000u /* ticks before the wrap at power-up; neither it nor 2^32 is a multiple of the periods below */
#define FIRST_TICK (0u - BEFORE)
#define STRIDE 7u
#define MAPPING_TICK 0x20300120u

static struct bt_drive drive;
static uint8_t message[BT_MAX_REPLY];

static void power_up(void)
{
    struct bt_config config = check_config();
    config.first_tick = FIRST_TICK;
    check_power_up_as(&drive, &config);
    assert(host_read(&drive, BT_ID_tick) == FIRST_TICK);
}

static void start_stream(void)
{
    uint8_t start[11] = { BT_STREAM, 1, STRIDE, 0, 4, 0, 1 };
    bt_put_u32(start + 7, MAPPING_TICK);
    host_nmt(&drive, BT_NMT_START);
    assert(host_ask(&drive, start, sizeof start, message, sizeof message) == 16 && bt_get_u32(message + 2) == BT_OK);
}

/* Multiples of the stride since power-up, over the wrap and when it is resumed after it. */
static void check_stream(void)
{
    uint64_t expected = ((uint64_t)FIRST_TICK / STRIDE + 1u) * STRIDE, due = 0;
    uint32_t k, records = 0;
    unsigned part;
    size_t n;
    power_up();
    start_stream();
    for (part = 0; part < 2; part++) {
        due -= bt_device_ticks(&drive.node.device) / STRIDE;
        for (k = 0; k < 2u * BEFORE; k++) {
            bt_tick(&drive);
            bt_poll(&drive);
            while ((n = host_hear(&drive, message, sizeof message)) > 0) {
                uint32_t at;
                if (message[0] != BT_BATCH)
                    continue;
                assert(bt_get_u16(message + 11) == STRIDE && n == 14u + 4u * message[13]);
                for (at = 0; at < message[13]; at++, expected += STRIDE, records++) {
                    assert(bt_get_u32(message + 7) + at * STRIDE == (uint32_t)expected);
                    assert(bt_get_u32(message + 14u + 4u * at) == (uint32_t)expected);
                }
            }
        }
        due += bt_device_ticks(&drive.node.device) / STRIDE;
        host_nmt(&drive, BT_NMT_ENTER_PRE_OPERATIONAL);
        while (host_hear(&drive, message, sizeof message) > 0) {
            if (message[0] == BT_BATCH)
                records += message[13];
        }
        bt_tick(&drive);
        expected = (bt_device_ticks(&drive.node.device) / STRIDE + 1u) * STRIDE;
        host_nmt(&drive, BT_NMT_START);
    }
    assert(records == due && bt_device_ticks(&drive.node.device) == ((uint64_t)1 << 32) + 3u * BEFORE + 2u);
}

static void check_capture(void)
{
    uint8_t open[5] = { BT_OPEN, 1, 0x42, 0x20, 0 }, ask[9] = { BT_CHUNKS, 2, 1, 0, 0, 0, 0, 1, 0 };
    uint32_t row;
    unsigned k;
    power_up();
    assert(host_write(&drive, BT_ID_capture_channel_1, MAPPING_TICK) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_rows, 50) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_stride, STRIDE) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_pretrigger, 20) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_trigger, BT_CAPTURE_TRIGGER_SETPOINT) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_control, 1) == BT_OK);
    for (k = 0; k < BEFORE + 10u; k++)
        bt_tick(&drive);
    assert(host_write(&drive, BT_ID_torque_command, bt_word_of(1.0f)) == BT_OK);
    for (k = 0; k < 30u * STRIDE; k++)
        bt_tick(&drive);
    assert(host_read(&drive, BT_ID_capture_state) == BT_CAPTURE_STATE_COMPLETE);
    assert(host_read(&drive, BT_ID_capture_trigger_tick) == 11u);
    assert(host_ask(&drive, open, sizeof open, message, sizeof message) == 20 && bt_get_u32(message + 2) == BT_OK);
    assert(host_ask(&drive, ask, sizeof ask, message, sizeof message) == 11u + 32u + 200u);
    assert(bt_get_u32(message + 11 + 16) > FIRST_TICK); /* the first row is of before the wrap */
    for (row = 0; row < 50; row++)
        assert(bt_get_u32(message + 43 + 4u * row) == bt_get_u32(message + 11 + 16) + row * STRIDE);
}

static void check_supervision(void)
{
    unsigned k;
    power_up();
    assert(host_write(&drive, BT_ID_host_heartbeat, (uint32_t)127 << 16 | 500) == BT_OK);
    for (k = 0; k < BEFORE - 100u; k++)
        bt_tick(&drive);
    host_heartbeat(&drive);
    host_enable(&drive);
    for (k = 0; k < 496; k++)
        bt_tick(&drive);
    assert(bt_may_switch(&drive) && host_read(&drive, BT_ID_tick) == 396);
    bt_tick(&drive);
    assert(!bt_may_switch(&drive));
}

/* On multiples of 300 ms since power-up, of which 2^32 is none. */
static void check_heartbeats(void)
{
    uint64_t expected = ((uint64_t)FIRST_TICK / 300u + 1u) * 300u;
    unsigned k, beats = 0;
    power_up();
    assert(host_write(&drive, BT_ID_producer_heartbeat, 300) == BT_OK);
    for (k = 0; k < 3u * BEFORE; k++) {
        bt_tick(&drive);
        bt_poll(&drive);
        while (host_hear(&drive, message, sizeof message) > 0) {
            assert(message[0] == BT_HEARTBEAT && bt_get_u32(message + 2) == (uint32_t)expected);
            expected += 300u;
            beats++;
        }
    }
    assert(beats == 10);
}

void check_wrap(void)
{
    check_stream();
    check_capture();
    check_supervision();
    check_heartbeats();
    printf("wrap: stream, capture, supervision, heartbeats\n");
}
