/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_cobs.h"

static void begin_piece(struct bt_cobs_encoder *encoder)
{
    encoder->code_at = encoder->next++;
    encoder->code = 1;
}

static void end_piece(struct bt_cobs_encoder *encoder)
{
    encoder->ring[encoder->code_at & encoder->mask] = encoder->code;
}

void bt_cobs_begin(struct bt_cobs_encoder *encoder, uint8_t *ring, uint32_t mask, uint32_t at)
{
    encoder->ring = ring;
    encoder->mask = mask;
    encoder->next = at;
    begin_piece(encoder);
}

/* A full piece is ended when the next byte comes: at the end of the data nothing may follow it. */
void bt_cobs_put(struct bt_cobs_encoder *encoder, const uint8_t *data, size_t n)
{
    size_t k;
    for (k = 0; k < n; k++) {
        if (encoder->code == 255u) {
            end_piece(encoder);
            begin_piece(encoder);
        }
        if (data[k] == 0) {
            end_piece(encoder);
            begin_piece(encoder);
        } else {
            encoder->ring[encoder->next++ & encoder->mask] = data[k];
            encoder->code++;
        }
    }
}

uint32_t bt_cobs_end(struct bt_cobs_encoder *encoder)
{
    end_piece(encoder);
    return encoder->next;
}

size_t bt_cobs_decode(uint8_t *data, size_t n)
{
    size_t from = 0, to = 0;
    while (from < n) {
        const size_t code = data[from++];
        size_t k;
        if (code == 0 || code - 1 > n - from)
            return BT_COBS_BAD;
        for (k = 1; k < code; k++)
            data[to++] = data[from++];
        if (code < 255u && from < n)
            data[to++] = 0;
    }
    return to;
}
