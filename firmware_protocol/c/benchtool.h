/* A drive of the bench, for its firmware: all that it includes.
 *
 *     static struct bt_drive drive;                      once; bt_init before anything else
 *
 *     control interrupt, at a constant rate:
 *         struct bt_variables *v = bt_variables(&drive);
 *         v->i_a = ...; v->omega_m = ...;                every signal of this tick
 *         if (overcurrent) bt_trip(&drive, BT_ERROR_OVERCURRENT);
 *         if (bt_may_switch(&drive)) control(v->torque_command) else all_switches_off();
 *         if (bt_is_quick_stopping(&drive)) brake, and bt_standstill(&drive) at its end
 *         bt_tick(&drive);                               last
 *
 *     receive interrupt:   bt_receive(&drive, bytes, n)
 *     transmit interrupt:  n = bt_transmit(&drive, bytes, capacity)
 *     main loop:           bt_poll(&drive), at least every 10 ms
 *
 * The four may interrupt each other in any order, but none itself. bt_tick takes a constant number of steps for a
 * given capture and stream, and neither waits nor loops over anything but their at most 16 channels each. */
#ifndef BENCHTOOL_H
#define BENCHTOOL_H

#include "bt_server.h"

struct bt_drive {
    struct bt_node node;
    struct bt_server serial;
};

/* All-zero memory, or one that was in use, becomes a drive just powered up. Parameters that were kept are given to
 * bt_restore before anything is received. */
void bt_init(struct bt_drive *drive, const struct bt_config *config);

/* Puts kept parameters in force, as `save` of the configuration was given them; false if they are not this table's. */
bool bt_restore(struct bt_drive *drive, const uint32_t *raw, size_t n);

/* Bytes from the line; how many were taken. The rest is lost, and the frame with them. */
size_t bt_receive(struct bt_drive *drive, const uint8_t *data, size_t n);

/* Bytes for the line; how many there are. */
size_t bt_transmit(struct bt_drive *drive, uint8_t *data, size_t capacity);

void bt_tick(struct bt_drive *drive);
void bt_poll(struct bt_drive *drive);

static inline struct bt_variables *bt_variables(struct bt_drive *drive)
{
    return &drive->node.device.variables;
}

/* Switch off and go into fault with this code of CiA 402: from now on bt_may_switch is false. */
static inline void bt_trip(struct bt_drive *drive, uint16_t code)
{
    bt_device_trip(&drive->node.device, code);
}

static inline bool bt_may_switch(const struct bt_drive *drive)
{
    return bt_device_may_switch(&drive->node.device);
}

static inline bool bt_is_quick_stopping(const struct bt_drive *drive)
{
    return bt_device_is_quick_stopping(&drive->node.device);
}

static inline void bt_standstill(struct bt_drive *drive)
{
    if (drive->node.device.state == BT_STATE_QUICK_STOP_ACTIVE)
        drive->node.device.standstill = true;
}

#endif
