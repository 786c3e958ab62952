/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_node.h"

#include <string.h>

#include "bt_sync.h"

static void emergency(void *context, uint16_t code, uint8_t error_register)
{
    const struct bt_node *node = context;
    unsigned k;
    for (k = 0; node->nmt_state != BT_NMT_STOPPED && k < node->line_count; k++)
        node->lines[k].emergency(node->lines[k].context, code, error_register);
}

static void enter(struct bt_node *node, uint8_t state)
{
    BT_STORE(&node->nmt_state, state);
}

static void boot(struct bt_node *node)
{
    unsigned k;
    bt_set_defaults(&node->device.variables, node->device.config.node_id, 0x1400u, 0x1BFFu, NULL);
    for (k = 0; k < node->line_count; k++)
        node->lines[k].boot(node->lines[k].context);
    enter(node, BT_NMT_PRE_OPERATIONAL);
}

void bt_node_init(struct bt_node *node, const struct bt_config *config)
{
    memset(node, 0, sizeof *node);
    bt_device_init(&node->device, config);
    node->device.emergency = emergency;
    node->device.emergency_context = node;
    enter(node, BT_NMT_PRE_OPERATIONAL);
}

void bt_node_add(struct bt_node *node, const struct bt_line *line)
{
    if (node->line_count < BT_LINES) {
        node->lines[node->line_count++] = *line;
        line->boot(line->context);
    }
}

void bt_node_command(struct bt_node *node, uint8_t command)
{
    unsigned k;
    switch (command) {
    case BT_NMT_START:
        enter(node, BT_NMT_OPERATIONAL);
        break;
    case BT_NMT_STOP:
        enter(node, BT_NMT_STOPPED);
        bt_device_stop(&node->device);
        break;
    case BT_NMT_ENTER_PRE_OPERATIONAL:
        enter(node, BT_NMT_PRE_OPERATIONAL);
        break;
    case BT_NMT_RESET_NODE:
        bt_device_reset(&node->device);
        boot(node);
        return;
    case BT_NMT_RESET_COMMUNICATION:
        boot(node);
        return;
    default:
        return;
    }
    for (k = 0; k < node->line_count; k++)
        node->lines[k].confirm(node->lines[k].context, node->nmt_state);
}

void bt_node_take_heartbeat(struct bt_node *node, uint8_t from)
{
    if (from != 0 && from == node->device.watchdog.host_node)
        bt_watchdog_feed(&node->device.watchdog, &node->device.variables.tick);
}

bool bt_node_take_setpoint(struct bt_node *node, const uint8_t torque[4], const uint8_t omega_m[4])
{
    if (bt_take_setpoint(&node->device, torque, omega_m) != BT_OK)
        return false;
    bt_watchdog_feed(&node->device.watchdog, &node->device.variables.tick);
    return true;
}

/* Heartbeats fall on whole multiples of their period since power-up. */
static void beat(struct bt_node *node)
{
    const uint64_t now = bt_device_ticks(&node->device);
    const uint64_t period_ns = (uint64_t)node->device.variables.producer_heartbeat * 1000000u;
    const uint32_t tick_ns = node->device.config.tick_period_ns;
    const uint32_t ticks = (uint32_t)((period_ns + tick_ns / 2u) / tick_ns);
    unsigned k;
    if (ticks != 0 && ticks == node->heartbeat_ticks) {
        if (now < node->heartbeat_next)
            return;
        for (k = 0; k < node->line_count; k++)
            node->lines[k].heartbeat(node->lines[k].context, node->nmt_state);
    }
    node->heartbeat_ticks = ticks;
    if (ticks != 0)
        node->heartbeat_next = (now / ticks + 1u) * ticks;
}

void bt_node_poll(struct bt_node *node)
{
    bt_device_look_after(&node->device);
    beat(node);
}

void bt_node_tick(struct bt_node *node)
{
    struct bt_device *device = &node->device;
    const bool tripped = BT_LOAD(&device->trip_edge);
    if (tripped) /* one that comes in between is seen in the next tick */
        BT_STORE(&device->trip_edge, false);
    if (++device->variables.tick == 0)
        device->tick_wraps = device->tick_wraps + 1u;
    bt_device_tick(device);
    bt_watchdog_tick(&device->watchdog, device->variables.tick);
    bt_capture_tick(&device->capture, &device->variables, tripped);
    bt_stream_tick(&node->stream, &device->variables);
}
