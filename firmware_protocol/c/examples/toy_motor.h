/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A toy motor and its control, in place of a control interrupt: a torque that follows its reference with 2 ms, an
 * inertia, little friction, a proportional speed loop. What else the dictionary has of signals is calculated from
 * these; nothing in it has the dynamics of a real machine. */
#ifndef TOY_MOTOR_H
#define TOY_MOTOR_H

#include "benchtool.h"

/* One tick: control, signals, protection, bt_tick. */
void toy_motor_tick(struct bt_drive *drive);

void toy_motor_at_rest(void);

#endif
