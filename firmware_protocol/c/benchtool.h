/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A drive of the bench, for its firmware: all that it includes.
 *
 *     static struct bt_drive drive;                      once; bt_init before anything else
 *
 *     control interrupt, at a constant rate:
 *         struct bt_variables *v = bt_variables(&drive);
 *         v->i_a = ...; v->omega_m = ...;                every signal of this tick
 *         if (overcurrent) bt_trip(&drive, BT_ERROR_OVERCURRENT);
 *         if (bt_is_quick_stopping(&drive)) brake, and bt_standstill(&drive) when the shaft stands or has turned back
 *         else control(bt_torque_setpoint(&drive)) or control(bt_omega_m_setpoint(&drive)), by mode
 *         if (!bt_may_switch(&drive)) all_switches_off();
 *         bt_tick(&drive);                               last
 *
 *     receive interrupt:   bt_receive(&drive, bytes, n)
 *     transmit interrupt:  n = bt_transmit(&drive, bytes, capacity)
 *     main loop:           bt_poll(&drive), at least every 10 ms
 *
 *     break interrupt:     bt_trip(&drive, code), from anywhere
 *
 * The four may interrupt each other in any order, but none itself. Threads in their place need BT_LOCK (bt_sync.h),
 * which the thread of the control interrupt holds for the whole of its tick. bt_tick takes a constant number of steps for a
 * given capture and stream, and neither waits nor loops over anything but their at most 16 channels each. */
#ifndef BENCHTOOL_H
#define BENCHTOOL_H

#include "bt_server.h"

#ifdef __cplusplus
extern "C" {
#endif

struct bt_drive {
    struct bt_node node;
    struct bt_server serial;
};

/* All-zero memory, or one that was in use, becomes a drive just powered up. Parameters that were kept are given to
 * bt_restore before anything is received. */
void bt_init(struct bt_drive *drive, const struct bt_config *config);

/* Puts kept parameters in force, as `save` of the configuration was given them. False if they are of another dictionary
 * or not what they may be: then all parameters have their defaults, which the firmware may want to tell. */
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

/* Switch off and go into fault with this code of CiA 402: from now on bt_may_switch is false. Code 0 does nothing. */
static inline void bt_trip(struct bt_drive *drive, uint16_t code)
{
    bt_device_trip(&drive->node.device, code);
}

/* What the current sensors of the outputs a, b and c read, in A: sets i_a, i_b and i_c, by the offsets, gains and phase
 * order that the host has set, and serves the calibration of the offsets. */
static inline void bt_take_currents(struct bt_drive *drive, const float reading[3])
{
    bt_device_take_currents(&drive->node.device, reading);
}

static inline bool bt_may_switch(const struct bt_drive *drive)
{
    return bt_device_may_switch(&drive->node.device);
}

static inline bool bt_is_quick_stopping(const struct bt_drive *drive)
{
    return bt_device_is_quick_stopping(&drive->node.device);
}

/* A quick stop has braked: the power stage goes off with this tick, or holds zero speed if the option says so. */
static inline void bt_standstill(struct bt_drive *drive)
{
    bt_device_standstill(&drive->node.device);
}

/* Whether the host has halted the axis: both setpoints are 0 then. */
static inline bool bt_is_halted(const struct bt_drive *drive)
{
    return bt_device_is_halted(&drive->node.device);
}

/* N·m and rad/s: what control is to follow now; torque_command and omega_m_command are what the host has written. */
static inline float bt_torque_setpoint(const struct bt_drive *drive)
{
    return bt_device_torque_setpoint(&drive->node.device);
}

static inline float bt_omega_m_setpoint(const struct bt_drive *drive)
{
    return bt_device_omega_m_setpoint(&drive->node.device);
}

#ifdef __cplusplus
}
#endif

#endif
