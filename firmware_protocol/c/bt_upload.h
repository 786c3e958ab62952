/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Long objects in chunks that the host asks for: one upload at a time, and the next one takes its place.
 *
 * Numbers and strings are kept from OPEN on. A capture's bytes stay where they are: when another one is armed, the
 * upload has ended. */
#ifndef BT_UPLOAD_H
#define BT_UPLOAD_H

#include "bt_device.h"
#include "bt_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_CHUNK_HEAD 11u
#define BT_CHUNK_BYTES (BT_MAX_REPLY - BT_CHUNK_HEAD < 1024u ? BT_MAX_REPLY - BT_CHUNK_HEAD : 1024u)

struct bt_upload {
    struct bt_value value;
    uint32_t sequence;   /* of the capture, if it is one */
    uint32_t next, left; /* chunks to be sent */
    bool is_open;
    uint8_t number, tag;
};

/* Keeps a value for the chunks to come; the CRC of its bytes. */
uint32_t bt_upload_open(struct bt_upload *upload, struct bt_device *device, const struct bt_value *value);

/* Takes a CHUNKS message: BT_OK, or why there are no chunks. */
uint32_t bt_upload_ask(struct bt_upload *upload, const struct bt_device *device, const uint8_t *request);

/* Sends chunks that were asked for while they fit; `buffer` takes BT_MAX_REPLY bytes. */
void bt_upload_send(struct bt_upload *upload, struct bt_device *device, struct bt_ring *line, uint8_t *buffer);

void bt_upload_end(struct bt_upload *upload);

#ifdef __cplusplus
}
#endif

#endif
