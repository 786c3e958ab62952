/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A drive on a CAN bus for tests from another language, without a motor: the test writes the signals. Built as a
 * shared object by `make library-canopen`. */
#include "shared_can.h"

#include <string.h>

static struct bt_node node;
static struct bt_can can;

int can_power_up(uint32_t tick_period_ns, uint32_t first_tick, uint8_t node_id, float i_full_scale,
                 float u_dc_full_scale, const uint32_t *kept, size_t n)
{
    struct bt_config config = { 0 };
    config.tick_period_ns = tick_period_ns;
    config.node_id = node_id;
    config.serial_number = 1;
    config.i_full_scale = i_full_scale;
    config.u_dc_full_scale = u_dc_full_scale;
    config.first_tick = first_tick;
    config.supported_modes = bt_entries[BT_ID_supported_modes].initial.u; /* all of the emulated drive */
    bt_node_init(&node, &config);
    if (n > 0 && !bt_preset(&node.device, kept, n))
        return 0;
    bt_device_reset(&node.device);
    bt_can_init(&can, &node);
    return 1;
}

struct bt_variables *can_variables(void)
{
    return &node.device.variables;
}

size_t can_size_of_variables(void)
{
    return sizeof node.device.variables;
}

int can_receive(uint16_t id, const uint8_t *data, size_t n)
{
    const bool kept = bt_can_receive(&can, id, data, n);
    bt_node_poll(&node);
    bt_can_poll(&can);
    return kept;
}

int can_transmit(uint16_t *id, uint8_t data[8])
{
    struct bt_can_frame frame;
    bt_can_poll(&can); /* segments that waited for room */
    if (!bt_can_transmit(&can, &frame))
        return -1;
    *id = frame.id;
    memcpy(data, frame.data, sizeof frame.data);
    return frame.n;
}

void can_tick(void)
{
    bt_node_tick(&node);
    bt_can_tick(&can);
    bt_node_poll(&node);
    bt_can_poll(&can);
}

void can_trip(uint16_t code)
{
    bt_device_trip(&node.device, code);
}

int can_arm_capture(void)
{
    const uint8_t arm = BT_CAPTURE_CONTROL_ARM;
    const struct bt_entry *entry = &bt_entries[BT_ID_capture_control];
    return bt_write(&node.device, entry->index, entry->sub, &arm, sizeof arm) == BT_OK;
}

void can_standstill(void)
{
    bt_device_standstill(&node.device);
}
