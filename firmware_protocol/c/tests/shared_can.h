/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* What tests from another language call; see shared_can.c. */
#ifndef SHARED_CAN_H
#define SHARED_CAN_H

#include "bt_canopen.h"

/* A drive just switched on with what was kept; 0 if that is not in force. */
int can_power_up(uint32_t tick_period_ns, uint32_t first_tick, uint8_t node_id, float i_full_scale,
                 float u_dc_full_scale, const uint32_t *kept, size_t n);

struct bt_variables *can_variables(void);
size_t can_size_of_variables(void);

/* Has a frame received and handled; 0 if it was lost. */
int can_receive(uint16_t id, const uint8_t *data, size_t n);

/* The next frame of the drive: how many data it has, or -1 if there is none. */
int can_transmit(uint16_t *id, uint8_t data[8]);

/* One tick, with the signals that are in the variables. */
void can_tick(void);

void can_trip(uint16_t code);

/* Has the capture that is set up armed, as over another line; 0 if it cannot be. */
int can_arm_capture(void);

/* A quick stop has come to its end. */
void can_standstill(void);

#endif
