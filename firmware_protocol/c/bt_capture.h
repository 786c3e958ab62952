/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* On-drive capture: rows of up to 16 signals at the control rate, around a trigger; object 0x2040 and its data.
 *
 * The control interrupt owns the rows while `state` is armed or triggered, the main loop at any other time. Each
 * hands over by a write of `state`, after everything else; the main loop reads and writes it with the lock held. */
#ifndef BT_CAPTURE_H
#define BT_CAPTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bt_config.h"
#include "bt_dictionary.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_CAPTURE_CHANNELS 16u
#define BT_CAPTURE_HEADER_BYTES 32u

struct bt_capture {
    volatile uint8_t state; /* enum bt_capture_state */
    uint8_t trigger;        /* enum bt_capture_trigger */
    uint8_t channels;
    bool level_is_float;
    bool compared; /* there is a value of the tick before */
    uint16_t offsets[BT_CAPTURE_CHANNELS];
    uint16_t trigger_offset;
    uint16_t stride, until_row;
    uint32_t rows, pretrigger;
    uint32_t position;           /* where in the ring the next row goes */
    volatile uint32_t rows_done; /* kept so far; while armed, those of before the trigger */
    uint32_t first_tick;
    volatile uint32_t trigger_tick;
    uint32_t sequence;
    float level, last_value;
    int64_t level_floor, level_ceiling, last_count; /* the same for a signal that is an integer */
    float last_torque_command, last_omega_m_command;
    bool sealed; /* `header` is that of the complete capture */
    uint8_t header[BT_CAPTURE_HEADER_BYTES];
    uint32_t words[BT_CAPTURE_WORDS];
};

/* Whether what the capture objects say can be armed: BT_OK or an abort code. */
uint32_t bt_capture_check(const struct bt_variables *variables);

/* Arms what they say; `bt_capture_check` has been content. */
void bt_capture_arm(struct bt_capture *capture, const struct bt_variables *variables);

/* Ends a capture that is under way; its rows are gone. */
void bt_capture_abort(struct bt_capture *capture);

/* Whether the capture with this sequence number is complete, so that its rows stay until another is armed. */
bool bt_capture_is_complete(const struct bt_capture *capture, uint32_t sequence);

/* In the control interrupt, when all signals of the tick are there. */
void bt_capture_tick(struct bt_capture *capture, const struct bt_variables *variables, bool tripped);

/* Bytes of object 0x2042 of a complete capture, and n of them. */
size_t bt_capture_size(const struct bt_capture *capture);
void bt_capture_read(struct bt_capture *capture, uint32_t tick_period_ns, size_t from, uint8_t *data, size_t n);

#ifdef __cplusplus
}
#endif

#endif
