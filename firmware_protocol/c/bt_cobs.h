/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Consistent overhead byte stuffing (Cheshire and Baker, 1999). */
#ifndef BT_COBS_H
#define BT_COBS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes that n bytes take at most, stuffed; one more than the tightest stuffing where it ends with a full piece. */
#define BT_COBS_LONGEST(n) ((n) + (n) / 254u + 1u)

#define BT_COBS_BAD SIZE_MAX

/* Stuffs byte by byte into a ring of bytes whose size is a power of two. */
struct bt_cobs_encoder {
    uint8_t *ring;
    uint32_t mask;
    uint32_t code_at; /* where the code of the piece begun goes */
    uint32_t next;    /* behind the last byte written; both count on and are masked */
    uint8_t code;
};

void bt_cobs_begin(struct bt_cobs_encoder *encoder, uint8_t *ring, uint32_t mask, uint32_t at);
void bt_cobs_put(struct bt_cobs_encoder *encoder, const uint8_t *data, size_t n);

/* Ends the data; where the ring goes on. */
uint32_t bt_cobs_end(struct bt_cobs_encoder *encoder);

/* Unstuffs n bytes that hold no zero, in place: the number of bytes, or BT_COBS_BAD. */
size_t bt_cobs_decode(uint8_t *data, size_t n);

#ifdef __cplusplus
}
#endif

#endif
