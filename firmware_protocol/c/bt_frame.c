/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_frame.h"

#include "bt_bytes.h"
#include "bt_crc.h"
#include "bt_sync.h"

void bt_ring_init(struct bt_ring *ring, uint8_t *data, uint32_t size)
{
    ring->head = 0;
    ring->tail = 0;
    ring->mask = size - 1u;
    ring->data = data;
}

uint32_t bt_ring_waiting(const struct bt_ring *ring)
{
    return BT_LOAD(&ring->head) - BT_LOAD(&ring->tail);
}

uint32_t bt_ring_free(const struct bt_ring *ring)
{
    return ring->mask + 1u - bt_ring_waiting(ring);
}

size_t bt_ring_put(struct bt_ring *ring, const uint8_t *data, size_t n)
{
    const uint32_t head = ring->head;
    const size_t room = bt_ring_free(ring);
    size_t k;
    if (n > room)
        n = room;
    for (k = 0; k < n; k++)
        ring->data[(head + k) & ring->mask] = data[k];
    BT_STORE(&ring->head, head + (uint32_t)n);
    return n;
}

size_t bt_ring_get(struct bt_ring *ring, uint8_t *data, size_t n)
{
    const uint32_t tail = ring->tail;
    const size_t waiting = bt_ring_waiting(ring);
    size_t k;
    if (n > waiting)
        n = waiting;
    for (k = 0; k < n; k++)
        data[k] = ring->data[(tail + k) & ring->mask];
    BT_STORE(&ring->tail, tail + (uint32_t)n);
    return n;
}

bool bt_frame_send(struct bt_ring *ring, const uint8_t *payload, size_t n, uint32_t reserve)
{
    struct bt_cobs_encoder encoder;
    uint8_t crc[BT_CRC_BYTES];
    uint32_t head = ring->head;
    if (bt_ring_free(ring) < BT_FRAME_LONGEST(n) + reserve)
        return false;
    bt_put_u32(crc, bt_crc(0, payload, n));
    ring->data[head++ & ring->mask] = 0;
    bt_cobs_begin(&encoder, ring->data, ring->mask, head);
    bt_cobs_put(&encoder, payload, n);
    bt_cobs_put(&encoder, crc, sizeof crc);
    head = bt_cobs_end(&encoder);
    ring->data[head++ & ring->mask] = 0;
    BT_STORE(&ring->head, head);
    return true;
}

void bt_receiver_init(struct bt_receiver *receiver, size_t max_payload)
{
    memset(receiver, 0, sizeof *receiver);
    receiver->longest = max_payload + BT_CRC_BYTES;
}

/* The payload of the whole frame in `data`, or 0; in the order in which the causes are tested. */
static size_t check(struct bt_receiver *receiver)
{
    const size_t n = bt_cobs_decode(receiver->data, receiver->n);
    if (n == BT_COBS_BAD) {
        receiver->bad_stuffing++;
        return 0;
    }
    if (n > receiver->longest) {
        receiver->too_long++;
        return 0;
    }
    if (n < 1u + BT_CRC_BYTES) {
        receiver->too_short++;
        return 0;
    }
    if (bt_crc(0, receiver->data, n - BT_CRC_BYTES) != bt_get_u32(receiver->data + n - BT_CRC_BYTES)) {
        receiver->bad_crc++;
        return 0;
    }
    receiver->frames++;
    return n - BT_CRC_BYTES;
}

size_t bt_receiver_take(struct bt_receiver *receiver, uint8_t byte)
{
    size_t n = 0;
    if (byte == 0) {
        if (!receiver->skipping && receiver->n > 0)
            n = check(receiver);
        receiver->skipping = false;
        receiver->n = 0;
    } else if (!receiver->skipping) {
        if (receiver->n == BT_COBS_LONGEST(receiver->longest)) {
            receiver->too_long++;
            receiver->skipping = true;
        } else {
            receiver->data[receiver->n++] = byte;
        }
    }
    return n;
}

uint32_t bt_receiver_dropped(const struct bt_receiver *receiver)
{
    return receiver->too_long + receiver->bad_stuffing + receiver->too_short + receiver->bad_crc;
}
