/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The parts of the test program. */
#ifndef CHECK_H
#define CHECK_H

#include "benchtool.h"

/* At 1 kHz, node 1. */
struct bt_config check_config(void);

/* A drive just powered up that has said so. */
void check_power_up(struct bt_drive *drive);
void check_power_up_as(struct bt_drive *drive, const struct bt_config *config);

void check_vectors(void);
void check_objects(void);
void check_control(void);
void check_targets(void);
void check_storage(void);
void check_currents(void);
void check_wrap(void);
void check_records(void);

#endif
