/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_upload.h"

#include "bt_bytes.h"
#include "bt_crc.h"

#define CHUNK_REPLY 0x85u

static bool is_there(const struct bt_upload *upload, const struct bt_device *device)
{
    if (!upload->is_open || !upload->value.is_capture)
        return upload->is_open;
    return bt_capture_is_complete(&device->capture, upload->sequence);
}

uint32_t bt_upload_open(struct bt_upload *upload, struct bt_device *device, const struct bt_value *value)
{
    uint8_t piece[64];
    uint32_t crc = 0;
    size_t from;
    upload->value = *value;
    upload->sequence = device->capture.sequence;
    upload->is_open = true;
    upload->number++;
    upload->left = 0;
    for (from = 0; from < value->n; from += sizeof piece) {
        const size_t n = value->n - from < sizeof piece ? value->n - from : sizeof piece;
        bt_value_copy(device, value, from, piece, n);
        crc = bt_crc(crc, piece, n);
    }
    return crc;
}

uint32_t bt_upload_ask(struct bt_upload *upload, const struct bt_device *device, const uint8_t *request)
{
    const uint32_t first = bt_get_u32(request + 3), count = bt_get_u16(request + 7);
    const size_t chunks = (upload->value.n + BT_CHUNK_BYTES - 1u) / BT_CHUNK_BYTES;
    upload->left = 0;
    if (!is_there(upload, device) || request[2] != upload->number)
        return BT_ABORT_DEVICE_STATE;
    if (count == 0)
        return BT_ABORT_VALUE_LOW;
    if (first >= chunks || count > chunks - first)
        return BT_ABORT_VALUE_HIGH;
    upload->next = first;
    upload->left = count;
    upload->tag = request[1];
    return BT_OK;
}

void bt_upload_send(struct bt_upload *upload, struct bt_device *device, struct bt_ring *line, uint8_t *buffer)
{
    while (upload->left > 0 && is_there(upload, device)) {
        const size_t from = (size_t)upload->next * BT_CHUNK_BYTES;
        size_t n = upload->value.n - from;
        if (n > BT_CHUNK_BYTES)
            n = BT_CHUNK_BYTES;
        if (bt_ring_free(line) < BT_FRAME_LONGEST(BT_CHUNK_HEAD + n) + BT_TX_RESERVE)
            return;
        buffer[0] = CHUNK_REPLY;
        buffer[1] = upload->tag;
        bt_put_u32(buffer + 2, BT_OK);
        buffer[6] = upload->number;
        bt_put_u32(buffer + 7, upload->next);
        bt_value_copy(device, &upload->value, from, buffer + BT_CHUNK_HEAD, n);
        (void)bt_frame_send(line, buffer, BT_CHUNK_HEAD + n, BT_TX_RESERVE);
        upload->next++;
        upload->left--;
    }
}

void bt_upload_end(struct bt_upload *upload)
{
    upload->is_open = false;
    upload->left = 0;
}
