/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "benchtool.h"

void bt_init(struct bt_drive *drive, const struct bt_config *config)
{
    bt_node_init(&drive->node, config);
    bt_server_init(&drive->serial, &drive->node);
}

bool bt_restore(struct bt_drive *drive, const uint32_t *raw, size_t n)
{
    const bool restored = bt_preset(&drive->node.device, raw, n);
    bt_device_reset(&drive->node.device);
    return restored;
}

size_t bt_receive(struct bt_drive *drive, const uint8_t *data, size_t n)
{
    return bt_ring_put(&drive->serial.rx, data, n);
}

size_t bt_transmit(struct bt_drive *drive, uint8_t *data, size_t capacity)
{
    return bt_ring_get(&drive->serial.tx, data, capacity);
}

void bt_tick(struct bt_drive *drive)
{
    bt_node_tick(&drive->node);
}

void bt_poll(struct bt_drive *drive)
{
    bt_node_poll(&drive->node);
    bt_server_poll(&drive->serial);
}
