/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A firmware in C++ in front of the library in C: every name links. */
#include "benchtool.h"
#include "bt_canopen.h"

static bt_drive drive;
static bt_can can;

int main()
{
    bt_config config = bt_config();
    bt_can_frame frame;
    config.tick_period_ns = 1000000u;
    config.node_id = 1;
    config.supported_modes = BT_MODE_BIT(BT_MODE_OF_OPERATION_TORQUE);
    bt_init(&drive, &config);
    bt_can_init(&can, &drive.node);
    bt_trip(&drive, BT_ERROR_OVERCURRENT);
    bt_tick(&drive);
    bt_can_tick(&can);
    bt_poll(&drive);
    bt_can_poll(&can);
    return bt_can_transmit(&can, &frame) && !bt_may_switch(&drive) && BT_VERSION >= BT_VERSION_NUMBER(0, 1, 0) ? 0 : 1;
}
