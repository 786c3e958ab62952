/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A drive in its own time for tests from another language: built as a shared object by `make library`. */
#include "shared.h"

#include <string.h>

#include "toy_motor.h"

static struct bt_drive drive;

int shared_power_up(uint32_t tick_period_ns, uint32_t first_tick, float i_full_scale, float u_dc_full_scale,
                    const uint32_t *kept, size_t n)
{
    struct bt_config config = { 0 };
    config.tick_period_ns = tick_period_ns;
    config.node_id = 1;
    config.serial_number = 1;
    config.first_tick = first_tick;
    config.i_full_scale = i_full_scale;
    config.u_dc_full_scale = u_dc_full_scale;
    config.supported_modes = bt_entries[BT_ID_supported_modes].initial.u; /* all of the emulated drive */
    config.hardware_version = "shared object";
    toy_motor_at_rest();
    bt_init(&drive, &config);
    return n == 0 || bt_restore(&drive, kept, n);
}

void shared_run(uint32_t ticks)
{
    while (ticks-- > 0) {
        toy_motor_tick(&drive);
        bt_poll(&drive);
    }
}

size_t shared_receive(const uint8_t *data, size_t n)
{
    const size_t taken = bt_receive(&drive, data, n);
    bt_poll(&drive);
    return taken;
}

size_t shared_transmit(uint8_t *data, size_t capacity)
{
    const size_t n = bt_transmit(&drive, data, capacity);
    bt_poll(&drive); /* what waited for room */
    return n;
}

size_t shared_frame(const uint8_t *payload, size_t n, uint8_t *frame, size_t capacity)
{
    static uint8_t data[16384];
    struct bt_ring line;
    bt_ring_init(&line, data, sizeof data);
    return bt_frame_send(&line, payload, n, 0) ? bt_ring_get(&line, frame, capacity) : 0;
}

static struct bt_receiver receiver;

void shared_receiver(size_t max_payload)
{
    bt_receiver_init(&receiver, max_payload);
}

size_t shared_take(uint8_t byte, uint8_t *payload)
{
    const size_t n = bt_receiver_take(&receiver, byte);
    memcpy(payload, receiver.data, n);
    return n;
}

void shared_dropped(uint32_t counts[4])
{
    counts[0] = receiver.too_long;
    counts[1] = receiver.bad_stuffing;
    counts[2] = receiver.too_short;
    counts[3] = receiver.bad_crc;
}
