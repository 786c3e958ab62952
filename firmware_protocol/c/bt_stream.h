/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The stream at the control rate: records from the control interrupt, batches by the main loop.
 *
 * The ring of records has the control interrupt as its one writer and the main loop as its one reader; each moves
 * its own counter. A record that finds the ring full is not kept, and counted. The main loop changes what a record
 * holds while `running` is off only, and switches that with the lock held. */
#ifndef BT_STREAM_H
#define BT_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bt_config.h"
#include "bt_device.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_STREAM_CHANNELS 16u
#define BT_BATCH_HEADER_BYTES 14u

struct bt_stream_layout {
    uint16_t stride;
    uint8_t batch, channels;
    bool scaled;
    uint8_t types[BT_STREAM_CHANNELS];
    uint16_t offsets[BT_STREAM_CHANNELS];
    float scales[BT_STREAM_CHANNELS];
};

struct bt_stream {
    struct bt_stream_layout layout;
    bool configured;
    volatile bool running;
    uint32_t next_tick;      /* of the next record; of the control interrupt */
    volatile uint32_t due;   /* records of this run, kept or not */
    volatile uint32_t head;  /* records kept */
    volatile uint32_t tail;  /* records taken */
    uint32_t slots, write_slot, read_slot;
    uint32_t accounted; /* records of this run that are in a batch, or counted as dropped */
    uint32_t expected_tick;
    uint32_t sequence, sent, dropped;
    uint16_t schema;
    uint32_t words[BT_STREAM_WORDS];
};

/* Takes a batch's payload; false if the line did not. */
typedef bool (*bt_send_batch)(void *context, const uint8_t *payload, size_t n);

/* The layout that a STREAM message of the right length asks for: BT_OK or an abort code. */
uint32_t bt_stream_layout(const uint8_t *message, struct bt_stream_layout *layout);

/* A new configuration, of a stream that does not run; records with bt_stream_resume, from the next tick that is a
 * multiple of the stride since power-up. */
void bt_stream_begin(struct bt_stream *stream, const struct bt_stream_layout *layout);
void bt_stream_resume(struct bt_stream *stream, const struct bt_device *device);
/* Record no more, and send what was; `buffer` takes BT_MAX_REPLY bytes. */
void bt_stream_pause(struct bt_stream *stream, uint8_t *buffer, bt_send_batch send, void *context);
/* Send the batches that are full; at most `most`. */
void bt_stream_transmit(struct bt_stream *stream, unsigned most, uint8_t *buffer, bt_send_batch send, void *context);

/* In the control interrupt, when all signals of the tick are there. */
void bt_stream_tick(struct bt_stream *stream, const struct bt_variables *variables);

/* A value in steps of a scale, as format 1 has it. */
int16_t bt_stream_scaled(float value, float scale);

#ifdef __cplusplus
}
#endif

#endif
