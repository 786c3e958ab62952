/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The SDO server (CiA 301, 7.2.4.3): expedited, segmented and block transfer, one at a time, both ways.
 *
 * A frame that does not fit the stage of the transfer ends it with abort 0x05040001; a new request ends one that
 * was under way. Numbers and strings are kept from the request on. A capture's bytes stay where they are: when
 * another one is armed, its upload is aborted with 0x08000022. */
#ifndef BT_CANOPEN_SDO_H
#define BT_CANOPEN_SDO_H

#include "bt_device.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_SDO_SEGMENT 7u

enum bt_sdo_stage {
    BT_SDO_IDLE,
    BT_SDO_SEGMENT_UPLOAD,
    BT_SDO_SEGMENT_DOWNLOAD,
    BT_SDO_BLOCK_UPLOAD_START,
    BT_SDO_BLOCK_UPLOAD_ACKNOWLEDGE,
    BT_SDO_BLOCK_UPLOAD_END,
    BT_SDO_BLOCK_DOWNLOAD_SEGMENT,
    BT_SDO_BLOCK_DOWNLOAD_END
};

struct bt_sdo {
    struct bt_device *device;
    uint8_t stage; /* enum bt_sdo_stage */
    uint8_t sub;
    uint16_t index;
    uint8_t toggle;
    bool with_crc;
    uint16_t crc; /* of the bytes that are through */

    /* upload */
    struct bt_value value;
    uint32_t sequence;   /* of the capture, if it is one */
    uint32_t segments;   /* of seven bytes each, at least one */
    uint32_t position;   /* segments that are through */
    uint8_t block_size;  /* segments of a sub-block, as the client asks for */
    uint8_t in_block;    /* of the present sub-block */
    uint8_t next;        /* of these, from 1 */

    /* download: the first bytes, which are all that a number has */
    bool announced;
    uint32_t announced_bytes;
    uint32_t taken; /* bytes; those of `last` not among them */
    uint8_t in_order;
    bool complete;
    uint8_t last[BT_SDO_SEGMENT];
    uint8_t data[8];
};

void bt_sdo_init(struct bt_sdo *sdo, struct bt_device *device);

/* Forget a transfer that is under way, as after a reset. */
void bt_sdo_end(struct bt_sdo *sdo);

/* Takes a frame of the client; whether `answer` is an answer to it. */
bool bt_sdo_take(struct bt_sdo *sdo, const uint8_t request[8], uint8_t answer[8]);

/* The next segment of a block upload that the client waits for; false if there is none. */
bool bt_sdo_next(struct bt_sdo *sdo, uint8_t segment[8]);

#ifdef __cplusplus
}
#endif

#endif
