/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* See shared.c. */
#ifndef SHARED_H
#define SHARED_H

#include "benchtool.h"

/* A drive just powered up, with what was kept; 0 if that is not in force. */
int shared_power_up(uint32_t tick_period_ns, uint32_t first_tick, float i_full_scale, float u_dc_full_scale,
                    const uint32_t *kept, size_t n);
/* Control and main loop, tick by tick. */
void shared_run(uint32_t ticks);
size_t shared_receive(const uint8_t *data, size_t n);
size_t shared_transmit(uint8_t *data, size_t capacity);

size_t shared_frame(const uint8_t *payload, size_t n, uint8_t *frame, size_t capacity);
void shared_receiver(size_t max_payload);
size_t shared_take(uint8_t byte, uint8_t *payload);
void shared_dropped(uint32_t counts[4]);

#endif
