/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The host's side in C, as little as the tests and the fuzzer need of it. */
#ifndef HOST_H
#define HOST_H

#include "benchtool.h"

/* Sends a payload as a frame, and has it handled. */
void host_send(struct bt_drive *drive, const uint8_t *payload, size_t n);

/* The next payload that the drive sent, or 0. A test fails if what it sent is damaged. */
size_t host_hear(struct bt_drive *drive, uint8_t *payload, size_t capacity);

/* Sends, drops what came unasked, and gives the answer. */
size_t host_ask(struct bt_drive *drive, const uint8_t *payload, size_t n, uint8_t *answer, size_t capacity);

/* The status of a write, and the number that an object has. */
uint32_t host_write(struct bt_drive *drive, enum bt_id id, uint32_t word);
uint32_t host_read(struct bt_drive *drive, enum bt_id id);

void host_nmt(struct bt_drive *drive, uint8_t command);
void host_heartbeat(struct bt_drive *drive);
void host_enable(struct bt_drive *drive);

#endif
