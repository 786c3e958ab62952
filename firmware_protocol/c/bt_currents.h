/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Current sensors: what they read becomes the currents of the motor's phases, by the parameters of object 0x2001; and
 * the calibration of their offsets, object 0x2017.
 *
 * The main loop starts and stops a calibration; it runs in the control interrupt. */
#ifndef BT_CURRENTS_H
#define BT_CURRENTS_H

#include <stdbool.h>
#include <stdint.h>

#include "bt_dictionary.h"

#ifdef __cplusplus
extern "C" {
#endif

struct bt_currents {
    volatile uint8_t state; /* enum bt_offset_calibration_state */
    uint32_t taken, ticks;
    float mean[3];
};

/* Main loop, with the lock held. */
void bt_currents_start(struct bt_currents *currents, const struct bt_variables *variables);
void bt_currents_stop(struct bt_currents *currents);

/* Control interrupt: takes what the sensors of the outputs a, b and c read, in A, and sets i_a, i_b and i_c. The power
 * stage going on ends a calibration, whose last reading puts the means in force. */
void bt_currents_take(struct bt_currents *currents, struct bt_variables *variables, const float reading[3],
                      bool power_stage_on);

#ifdef __cplusplus
}
#endif

#endif
