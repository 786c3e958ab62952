/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Frames of the serial line: a receiver that bytes go into, and frames into a ring of bytes that the line drains.
 *
 * Each ring has one that writes and one that reads. Either may interrupt the other, as each alone moves its own
 * counter, and moves it after the bytes. */
#ifndef BT_FRAME_H
#define BT_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bt_cobs.h"
#include "bt_config.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_CRC_BYTES 4u

struct bt_ring {
    volatile uint32_t head; /* bytes ever written */
    volatile uint32_t tail; /* bytes ever read */
    uint32_t mask;
    uint8_t *data;
};

/* `size` is a power of two. */
void bt_ring_init(struct bt_ring *ring, uint8_t *data, uint32_t size);
uint32_t bt_ring_waiting(const struct bt_ring *ring);
uint32_t bt_ring_free(const struct bt_ring *ring);
/* Bytes that fitted or were there. */
size_t bt_ring_put(struct bt_ring *ring, const uint8_t *data, size_t n);
size_t bt_ring_get(struct bt_ring *ring, uint8_t *data, size_t n);

/* Bytes of the longest frame of a payload of n bytes, zeros included. */
#define BT_FRAME_LONGEST(n) (BT_COBS_LONGEST((n) + BT_CRC_BYTES) + 2u)

/* Puts the frame of a payload into a ring, unless fewer than `reserve` bytes would be free then. */
bool bt_frame_send(struct bt_ring *ring, const uint8_t *payload, size_t n, uint32_t reserve);

struct bt_receiver {
    uint32_t frames; /* good ones */
    uint32_t too_long, bad_stuffing, too_short, bad_crc;
    size_t longest; /* of payload and CRC */
    size_t n;       /* bytes of the frame begun */
    bool skipping;  /* the frame begun is too long, and counted */
    uint8_t data[BT_COBS_LONGEST(BT_MAX_REQUEST + BT_CRC_BYTES)];
};

/* `max_payload` is at most BT_MAX_REQUEST. */
void bt_receiver_init(struct bt_receiver *receiver, size_t max_payload);

/* Takes one byte; the length of the payload now in `data` if a good frame ends with it, else 0. */
size_t bt_receiver_take(struct bt_receiver *receiver, uint8_t byte);

/* Frames dropped for whatever cause. */
uint32_t bt_receiver_dropped(const struct bt_receiver *receiver);

#ifdef __cplusplus
}
#endif

#endif
