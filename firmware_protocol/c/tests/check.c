/* The tests that need no host: run by `make check`, with and without sanitizers. */
#undef NDEBUG
#include "check.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "host.h"

void check_power_up(struct bt_drive *drive)
{
    struct bt_config config = { 0 };
    uint8_t boot[8];
    config.tick_period_ns = 1000000u;
    config.node_id = 1;
    config.serial_number = 7;
    memset(drive, 0x5A, sizeof *drive); /* what was there does not matter */
    bt_init(drive, &config);
    assert(host_hear(drive, boot, sizeof boot) == 6 && boot[0] == BT_HEARTBEAT && boot[1] == 0);
}

int main(void)
{
    check_vectors();
    check_objects();
    check_control();
    check_records();
    printf("all content\n");
    return 0;
}
