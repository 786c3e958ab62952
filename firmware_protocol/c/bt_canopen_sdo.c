/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_canopen_sdo.h"

#include "bt_bytes.h"

#define ABORT_TOGGLE_BIT 0x05030000u
#define ABORT_COMMAND 0x05040001u
#define ABORT_BLOCK_SIZE 0x05040002u
#define ABORT_SEQUENCE_NUMBER 0x05040003u
#define ABORT_CRC 0x05040004u
#define ABORT_LENGTH 0x06070010u

#define ABORTED 0x80u
#define MOST_IN_BLOCK 127u
#define LAST_SEGMENT 0x80u /* in the number of a segment of a block */
#define EXPEDITED 0x02u
#define SIZE_INDICATED 0x01u /* by the initiation of an expedited or segmented transfer */
#define NO_MORE 0x01u        /* in the command of a segment */
#define TOGGLE 0x10u
#define BLOCK_SIZE_INDICATED 0x02u
#define BLOCK_CRC 0x04u

/* What a request leads to besides an abort code, which is never one of these. */
#define ANSWERED BT_OK
#define NO_ANSWER 1u

/* The CRC of block transfer (7.2.4.3.16): x^16 + x^12 + x^5 + 1, from 0. */
static uint16_t crc_of(uint16_t crc, const uint8_t *data, size_t n)
{
    while (n-- > 0) {
        unsigned bit;
        crc = (uint16_t)(crc ^ *data++ << 8);
        for (bit = 0; bit < 8; bit++)
            crc = (uint16_t)((unsigned)crc << 1 ^ (crc & 0x8000u ? 0x1021u : 0u));
    }
    return crc;
}

void bt_sdo_init(struct bt_sdo *sdo, struct bt_device *device)
{
    memset(sdo, 0, sizeof *sdo);
    sdo->device = device;
}

void bt_sdo_end(struct bt_sdo *sdo)
{
    sdo->stage = BT_SDO_IDLE;
}

static void head(const struct bt_sdo *sdo, uint8_t *answer, uint8_t command)
{
    answer[0] = command;
    bt_put_u16(answer + 1, sdo->index);
    answer[3] = sdo->sub;
}

static void name_object(struct bt_sdo *sdo, const uint8_t *request)
{
    sdo->stage = BT_SDO_IDLE;
    sdo->index = bt_get_u16(request + 1);
    sdo->sub = request[3];
}

/* ---- upload --------------------------------------------------------------------------------------------- */

static bool is_there(const struct bt_sdo *sdo)
{
    return !sdo->value.is_capture || bt_capture_is_complete(&sdo->device->capture, sdo->sequence);
}

static uint32_t read_object(struct bt_sdo *sdo, const uint8_t *request)
{
    uint32_t status;
    name_object(sdo, request);
    status = bt_read(sdo->device, sdo->index, sdo->sub, &sdo->value);
    if (status != BT_OK)
        return status;
    sdo->sequence = sdo->device->capture.sequence;
    sdo->segments = (uint32_t)((sdo->value.n + BT_SDO_SEGMENT - 1u) / BT_SDO_SEGMENT);
    if (sdo->segments == 0)
        sdo->segments = 1;
    sdo->position = 0;
    return BT_OK;
}

/* Bytes of a segment, which is one of those there are; how many. */
static size_t segment_bytes(struct bt_sdo *sdo, uint32_t segment, uint8_t *data)
{
    const size_t from = (size_t)segment * BT_SDO_SEGMENT;
    size_t n = sdo->value.n - from;
    if (n > BT_SDO_SEGMENT)
        n = BT_SDO_SEGMENT;
    bt_value_copy(sdo->device, &sdo->value, from, data, n);
    return n;
}

static uint32_t begin_upload(struct bt_sdo *sdo, uint8_t *answer)
{
    const size_t n = sdo->value.n;
    if (n >= 1 && n <= 4) {
        head(sdo, answer, (uint8_t)(0x40u | EXPEDITED | SIZE_INDICATED | (4u - n) << 2));
        bt_value_copy(sdo->device, &sdo->value, 0, answer + 4, n);
        return ANSWERED;
    }
    sdo->toggle = 0;
    sdo->stage = BT_SDO_SEGMENT_UPLOAD;
    head(sdo, answer, 0x40u | SIZE_INDICATED);
    bt_put_u32(answer + 4, (uint32_t)n);
    return ANSWERED;
}

static uint32_t upload_segment(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    size_t n;
    if ((request[0] & TOGGLE) != sdo->toggle)
        return ABORT_TOGGLE_BIT;
    if (!is_there(sdo))
        return BT_ABORT_DEVICE_STATE;
    n = segment_bytes(sdo, sdo->position++, answer + 1);
    answer[0] = (uint8_t)(sdo->toggle | (BT_SDO_SEGMENT - n) << 1);
    if (sdo->position == sdo->segments) {
        answer[0] |= NO_MORE;
        sdo->stage = BT_SDO_IDLE;
    }
    sdo->toggle ^= TOGGLE;
    return ANSWERED;
}

static uint32_t begin_block_upload(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    const uint8_t size = request[4], threshold = request[5];
    const uint32_t status = read_object(sdo, request);
    if (status != BT_OK)
        return status;
    if (threshold > 0 && sdo->value.n <= threshold)
        return begin_upload(sdo, answer); /* the client allows the other protocol for so few bytes (7.2.4.3.13) */
    if (size < 1 || size > MOST_IN_BLOCK)
        return ABORT_BLOCK_SIZE;
    sdo->block_size = size;
    sdo->with_crc = request[0] & BLOCK_CRC;
    sdo->crc = 0;
    sdo->stage = BT_SDO_BLOCK_UPLOAD_START;
    head(sdo, answer, 0xC0u | BLOCK_CRC | BLOCK_SIZE_INDICATED);
    bt_put_u32(answer + 4, (uint32_t)sdo->value.n);
    return ANSWERED;
}

static uint32_t begin_sub_block(struct bt_sdo *sdo)
{
    const uint32_t left = sdo->segments - sdo->position;
    sdo->in_block = left < sdo->block_size ? (uint8_t)left : sdo->block_size;
    sdo->next = 1;
    sdo->stage = BT_SDO_BLOCK_UPLOAD_ACKNOWLEDGE;
    return NO_ANSWER;
}

static uint32_t acknowledge(struct bt_sdo *sdo, uint8_t in_order, uint8_t size, uint8_t *answer)
{
    uint8_t data[BT_SDO_SEGMENT];
    size_t n = 0;
    if (in_order > sdo->in_block)
        return ABORT_SEQUENCE_NUMBER;
    if (!is_there(sdo))
        return BT_ABORT_DEVICE_STATE;
    for (; in_order > 0; in_order--) {
        n = segment_bytes(sdo, sdo->position++, data);
        if (sdo->with_crc)
            sdo->crc = crc_of(sdo->crc, data, n);
    }
    if (sdo->position == sdo->segments) {
        sdo->stage = BT_SDO_BLOCK_UPLOAD_END;
        answer[0] = (uint8_t)(0xC1u | (BT_SDO_SEGMENT - n) << 2);
        bt_put_u16(answer + 1, sdo->crc);
        return ANSWERED;
    }
    if (size < 1 || size > MOST_IN_BLOCK)
        return ABORT_BLOCK_SIZE;
    sdo->block_size = size;
    return begin_sub_block(sdo);
}

static uint32_t block_upload(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    const unsigned command = request[0] & 3u;
    if (command == 0)
        return begin_block_upload(sdo, request, answer);
    if (command == 3 && sdo->stage == BT_SDO_BLOCK_UPLOAD_START)
        return begin_sub_block(sdo);
    if (command == 2 && sdo->stage == BT_SDO_BLOCK_UPLOAD_ACKNOWLEDGE)
        return acknowledge(sdo, request[1], request[2], answer);
    if (command != 1 || sdo->stage != BT_SDO_BLOCK_UPLOAD_END)
        return ABORT_COMMAND;
    sdo->stage = BT_SDO_IDLE;
    return NO_ANSWER;
}

/* ---- download ------------------------------------------------------------------------------------------- */

static void take_bytes(struct bt_sdo *sdo, const uint8_t *data, size_t n)
{
    size_t k;
    for (k = 0; k < n; k++) {
        if (sdo->taken + k < sizeof sdo->data)
            sdo->data[sdo->taken + k] = data[k];
    }
    sdo->taken += (uint32_t)n;
}

/* Of more bytes than any number has, that there are too many is all that counts. */
static uint32_t write_object(struct bt_sdo *sdo)
{
    const size_t n = sdo->taken < sizeof sdo->data ? sdo->taken : sizeof sdo->data;
    if (sdo->announced && sdo->announced_bytes != sdo->taken)
        return ABORT_LENGTH;
    return bt_write(sdo->device, sdo->index, sdo->sub, sdo->data, n);
}

/* Bytes of an expedited transfer; without size indication, as many as the object takes (7.2.4.3.3). */
static size_t expedited_bytes(const struct bt_sdo *sdo, uint8_t command)
{
    enum bt_id id;
    if (command & SIZE_INDICATED)
        return 4u - (command >> 2 & 3u);
    return bt_find(sdo->index, sdo->sub, &id) == BT_OK && bt_entries[id].size > 0 ? bt_entries[id].size : 4u;
}

static uint32_t begin_download(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    uint32_t status = BT_OK;
    name_object(sdo, request);
    sdo->taken = 0;
    sdo->announced = false;
    if (request[0] & EXPEDITED) {
        take_bytes(sdo, request + 4, expedited_bytes(sdo, request[0]));
        status = write_object(sdo);
    } else {
        sdo->announced = request[0] & SIZE_INDICATED;
        sdo->announced_bytes = bt_get_u32(request + 4);
        sdo->toggle = 0;
        sdo->stage = BT_SDO_SEGMENT_DOWNLOAD;
    }
    head(sdo, answer, 0x60u);
    return status;
}

static uint32_t download_segment(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    if ((request[0] & TOGGLE) != sdo->toggle)
        return ABORT_TOGGLE_BIT;
    take_bytes(sdo, request + 1, BT_SDO_SEGMENT - (request[0] >> 1 & 7u));
    answer[0] = (uint8_t)(0x20u | sdo->toggle);
    sdo->toggle ^= TOGGLE;
    if (!(request[0] & NO_MORE))
        return ANSWERED;
    sdo->stage = BT_SDO_IDLE;
    return write_object(sdo);
}

static uint32_t begin_block_download(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    name_object(sdo, request);
    sdo->announced = request[0] & BLOCK_SIZE_INDICATED;
    sdo->announced_bytes = bt_get_u32(request + 4);
    sdo->with_crc = request[0] & BLOCK_CRC;
    sdo->crc = 0;
    sdo->taken = 0;
    sdo->segments = 0;
    sdo->in_order = 0;
    sdo->complete = false;
    sdo->stage = BT_SDO_BLOCK_DOWNLOAD_SEGMENT;
    head(sdo, answer, 0xA0u | BLOCK_CRC);
    bt_put_u32(answer + 4, MOST_IN_BLOCK);
    return ANSWERED;
}

/* How many bytes of the last segment count is said at the end only: each segment waits for the next one. */
static uint32_t keep_segment(struct bt_sdo *sdo, const uint8_t *data)
{
    const uint32_t announced = sdo->announced_bytes > 0 ? sdo->announced_bytes : 1u;
    if (sdo->segments > 0) {
        sdo->crc = crc_of(sdo->crc, sdo->last, BT_SDO_SEGMENT);
        take_bytes(sdo, sdo->last, BT_SDO_SEGMENT);
    }
    memcpy(sdo->last, data, BT_SDO_SEGMENT);
    sdo->segments++;
    if (sdo->announced && sdo->segments > (announced - 1u) / BT_SDO_SEGMENT + 1u)
        return BT_ABORT_LENGTH_HIGH;
    return BT_OK;
}

static uint32_t block_segment(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    const uint8_t number = request[0] & MOST_IN_BLOCK;
    const bool last = request[0] & LAST_SEGMENT;
    if (number == 0)
        return ABORT_SEQUENCE_NUMBER;
    if (number == sdo->in_order + 1u) {
        const uint32_t status = keep_segment(sdo, request + 1);
        if (status != BT_OK)
            return status;
        sdo->in_order = number;
        sdo->complete = last;
    }
    if (sdo->complete)
        sdo->stage = BT_SDO_BLOCK_DOWNLOAD_END;
    if (!last && number < MOST_IN_BLOCK)
        return NO_ANSWER;
    answer[0] = 0xA2u;
    answer[1] = sdo->in_order;
    answer[2] = MOST_IN_BLOCK;
    sdo->in_order = 0;
    return ANSWERED;
}

static uint32_t end_block_download(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    const size_t n = BT_SDO_SEGMENT - (request[0] >> 2 & 7u);
    sdo->stage = BT_SDO_IDLE;
    take_bytes(sdo, sdo->last, n);
    if (sdo->announced && sdo->announced_bytes != sdo->taken)
        return ABORT_LENGTH;
    if (sdo->with_crc && bt_get_u16(request + 1) != crc_of(sdo->crc, sdo->last, n))
        return ABORT_CRC;
    answer[0] = 0xA1u;
    return write_object(sdo);
}

/* ---- requests ------------------------------------------------------------------------------------------- */

static uint32_t dispatch(struct bt_sdo *sdo, const uint8_t *request, uint8_t *answer)
{
    uint32_t status;
    switch (request[0] >> 5) {
    case 0:
        return sdo->stage == BT_SDO_SEGMENT_DOWNLOAD ? download_segment(sdo, request, answer) : ABORT_COMMAND;
    case 1:
        return begin_download(sdo, request, answer);
    case 2:
        status = read_object(sdo, request);
        return status == BT_OK ? begin_upload(sdo, answer) : status;
    case 3:
        return sdo->stage == BT_SDO_SEGMENT_UPLOAD ? upload_segment(sdo, request, answer) : ABORT_COMMAND;
    case 5:
        return block_upload(sdo, request, answer);
    case 6:
        if (!(request[0] & 1u))
            return begin_block_download(sdo, request, answer);
        return sdo->stage == BT_SDO_BLOCK_DOWNLOAD_END ? end_block_download(sdo, request, answer) : ABORT_COMMAND;
    default:
        return ABORT_COMMAND;
    }
}

static void abort_transfer(struct bt_sdo *sdo, uint32_t code, uint8_t *answer)
{
    sdo->stage = BT_SDO_IDLE;
    head(sdo, answer, ABORTED);
    bt_put_u32(answer + 4, code);
}

bool bt_sdo_take(struct bt_sdo *sdo, const uint8_t request[8], uint8_t answer[8])
{
    uint32_t status;
    memset(answer, 0, 8);
    if (request[0] == ABORTED) {
        bt_sdo_end(sdo);
        return false;
    }
    status = sdo->stage == BT_SDO_BLOCK_DOWNLOAD_SEGMENT ? block_segment(sdo, request, answer)
                                                         : dispatch(sdo, request, answer);
    if (status != ANSWERED && status != NO_ANSWER)
        abort_transfer(sdo, status, answer);
    return status != NO_ANSWER;
}

bool bt_sdo_next(struct bt_sdo *sdo, uint8_t segment[8])
{
    if (sdo->stage != BT_SDO_BLOCK_UPLOAD_ACKNOWLEDGE || sdo->next > sdo->in_block)
        return false;
    memset(segment, 0, 8);
    if (!is_there(sdo)) {
        abort_transfer(sdo, BT_ABORT_DEVICE_STATE, segment);
        return true;
    }
    segment_bytes(sdo, sdo->position + sdo->next - 1u, segment + 1);
    segment[0] = sdo->next;
    if (sdo->position + sdo->next == sdo->segments)
        segment[0] |= LAST_SEGMENT;
    sdo->next++;
    return true;
}
