/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "host.h"

#include <assert.h>

#include "bt_bytes.h"

void host_send(struct bt_drive *drive, const uint8_t *payload, size_t n)
{
    static uint8_t data[16384], byte;
    struct bt_ring line;
    bt_ring_init(&line, data, sizeof data);
    assert(bt_frame_send(&line, payload, n, 0));
    while (bt_ring_get(&line, &byte, 1) == 1) {
        if (bt_receive(drive, &byte, 1) == 0) {
            bt_poll(drive);
            assert(bt_receive(drive, &byte, 1) == 1);
        }
    }
    bt_poll(drive);
}

size_t host_hear(struct bt_drive *drive, uint8_t *payload, size_t capacity)
{
    static uint8_t data[BT_FRAME_LONGEST(BT_MAX_REPLY)];
    size_t n = 0;
    uint8_t byte;
    while (bt_transmit(drive, &byte, 1) == 1) {
        if (byte != 0) {
            assert(n < sizeof data);
            data[n++] = byte;
            continue;
        }
        if (n == 0)
            continue;
        n = bt_cobs_decode(data, n);
        assert(n != BT_COBS_BAD && n > BT_CRC_BYTES && n - BT_CRC_BYTES <= BT_MAX_REPLY);
        assert(n - BT_CRC_BYTES <= capacity);
        memcpy(payload, data, n - BT_CRC_BYTES);
        return n - BT_CRC_BYTES;
    }
    assert(n == 0);
    return 0;
}

size_t host_ask(struct bt_drive *drive, const uint8_t *payload, size_t n, uint8_t *answer, size_t capacity)
{
    size_t length;
    host_send(drive, payload, n);
    while ((length = host_hear(drive, answer, capacity)) > 0 && answer[0] < BT_ANSWER) {
    }
    return length;
}

uint32_t host_write(struct bt_drive *drive, enum bt_id id, uint32_t word)
{
    uint8_t message[9] = { BT_WRITE, 1 }, answer[BT_MAX_REPLY];
    bt_put_u16(message + 2, bt_entries[id].index);
    message[4] = bt_entries[id].sub;
    bt_put_u32(message + 5, word);
    assert(host_ask(drive, message, 5u + bt_entries[id].size, answer, sizeof answer) == 9);
    assert(answer[0] == BT_WRITE + BT_ANSWER && answer[1] == 1 && memcmp(answer + 6, message + 2, 3) == 0);
    return bt_get_u32(answer + 2);
}

uint32_t host_read(struct bt_drive *drive, enum bt_id id)
{
    uint8_t message[5] = { BT_READ, 2 }, answer[BT_MAX_REPLY], word[4] = { 0 };
    size_t n;
    bt_put_u16(message + 2, bt_entries[id].index);
    message[4] = bt_entries[id].sub;
    n = host_ask(drive, message, sizeof message, answer, sizeof answer);
    assert(answer[0] == BT_READ + BT_ANSWER && bt_get_u32(answer + 2) == BT_OK && n == 9u + bt_entries[id].size);
    memcpy(word, answer + 9, n - 9u);
    return bt_get_u32(word);
}

void host_nmt(struct bt_drive *drive, uint8_t command)
{
    const uint8_t message[2] = { BT_NMT, command };
    host_send(drive, message, sizeof message);
}

void host_heartbeat(struct bt_drive *drive)
{
    const uint8_t message[3] = { BT_HOST_HEARTBEAT, 127, 5 };
    host_send(drive, message, sizeof message);
}

void host_enable(struct bt_drive *drive)
{
    host_nmt(drive, BT_NMT_START);
    assert(host_write(drive, BT_ID_controlword, 6) == BT_OK);
    assert(host_write(drive, BT_ID_controlword, 7) == BT_OK);
    assert(host_write(drive, BT_ID_controlword, 15) == BT_OK);
    assert((host_read(drive, BT_ID_statusword) & 0x6Fu) == 0x27u);
}
