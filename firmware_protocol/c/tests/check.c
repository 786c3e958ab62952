/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The tests that need no host: run by `make check`, with and without sanitizers. */
#undef NDEBUG
#include "check.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "host.h"

struct bt_config check_config(void)
{
    struct bt_config config = { 0 };
    config.tick_period_ns = 1000000u;
    config.node_id = 1;
    config.serial_number = 7;
    return config;
}

void check_power_up_as(struct bt_drive *drive, const struct bt_config *config)
{
    uint8_t boot[8];
    memset(drive, 0x5A, sizeof *drive); /* what was there does not matter */
    bt_init(drive, config);
    assert(host_hear(drive, boot, sizeof boot) == 6 && boot[0] == BT_HEARTBEAT && boot[1] == 0);
}

void check_power_up(struct bt_drive *drive)
{
    const struct bt_config config = check_config();
    check_power_up_as(drive, &config);
}

int main(void)
{
    check_vectors();
    check_objects();
    check_control();
    check_targets();
    check_storage();
    check_currents();
    check_wrap();
    check_records();
    printf("all content\n");
    return 0;
}
