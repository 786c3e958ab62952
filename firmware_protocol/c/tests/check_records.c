/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Capture and stream: which ticks they hold, and what they say of those they do not. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "bt_crc.h"
#include "check.h"
#include "host.h"

#define MAPPING_TICK 0x20300120u
#define MAPPING_TORQUE 0x20300C20u

static struct bt_drive drive;

static void run(unsigned ticks)
{
    while (ticks-- > 0) {
        bt_variables(&drive)->torque = (float)(bt_variables(&drive)->tick + 1u);
        bt_tick(&drive);
    }
}

static void arm(uint32_t rows, uint32_t stride, uint32_t pretrigger, uint32_t trigger)
{
    assert(host_write(&drive, BT_ID_capture_channel_1, MAPPING_TICK) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_channel_2, MAPPING_TORQUE) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_rows, rows) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_stride, stride) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_pretrigger, pretrigger) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_trigger, trigger) == BT_OK);
    assert(host_write(&drive, BT_ID_capture_control, 1) == BT_OK);
}

/* Uploads the capture; its bytes. */
static size_t upload(uint8_t *data)
{
    uint8_t open[5] = { BT_OPEN, 1, 0x42, 0x20, 0 }, ask[9] = { BT_CHUNKS, 2 }, answer[BT_MAX_REPLY];
    uint32_t size, chunk, count, chunk_size;
    assert(host_ask(&drive, open, sizeof open, answer, sizeof answer) == 20 && bt_get_u32(answer + 2) == BT_OK);
    size = bt_get_u32(answer + 10);
    chunk_size = bt_get_u16(answer + 14);
    count = (size + chunk_size - 1u) / chunk_size;
    ask[2] = answer[9];
    for (chunk = 0; chunk < count; chunk++) {
        const uint32_t crc = bt_get_u32(answer + 16);
        size_t n;
        bt_put_u32(ask + 3, chunk);
        bt_put_u16(ask + 7, 1);
        n = host_ask(&drive, ask, sizeof ask, data + chunk * chunk_size, BT_MAX_REPLY);
        assert(n > 11);
        memmove(data + chunk * chunk_size, data + chunk * chunk_size + 11, n - 11);
        if (chunk + 1u == count)
            assert(bt_crc(0, data, size) == crc && size == chunk * chunk_size + n - 11);
    }
    return size;
}

static void check_capture(uint32_t rows, uint32_t stride, uint32_t pretrigger, uint32_t before)
{
    static uint8_t data[BT_CAPTURE_WORDS * 4u + 4u * BT_MAX_REPLY];
    uint32_t row, first, kept;
    check_power_up(&drive);
    run(17);
    arm(rows, stride, pretrigger, BT_CAPTURE_TRIGGER_SETPOINT);
    run(before);
    assert(host_write(&drive, BT_ID_torque_command, bt_word_of(1.0f)) == BT_OK);
    run(rows * stride);
    assert(host_read(&drive, BT_ID_capture_state) == BT_CAPTURE_STATE_COMPLETE);
    assert(upload(data) == 32u + rows * 8u);
    assert(bt_crc(bt_crc(0, data, 28), data + 32, rows * 8u) == bt_get_u32(data + 28));
    assert(bt_get_u32(data + 20) == 17u + before + 1u);
    kept = (before + stride - 1u) / stride < pretrigger ? (before + stride - 1u) / stride : pretrigger;
    first = bt_get_u32(data + 16);
    assert(first == 18u + ((before + stride - 1u) / stride - kept) * stride);
    for (row = 0; row < rows; row++) {
        assert(bt_get_u32(data + 32 + 8 * row) == first + row * stride);
        assert(bt_float_of(bt_get_u32(data + 36 + 8 * row)) == (float)(first + row * stride));
    }
}

static void check_end_of_upload(void)
{
    uint8_t open[5] = { BT_OPEN, 1, 0x42, 0x20, 0 }, ask[9] = { BT_CHUNKS, 2, 1, 0, 0, 0, 0, 1, 0 };
    uint8_t answer[BT_MAX_REPLY];
    check_power_up(&drive);
    arm(10, 1, 0, BT_CAPTURE_TRIGGER_IMMEDIATE);
    run(10);
    assert(host_ask(&drive, open, sizeof open, answer, sizeof answer) == 20 && answer[9] == 1);
    assert(host_ask(&drive, ask, sizeof ask, answer, sizeof answer) == 11 + 112);
    memset(ask + 3, 0xFF, 4); /* the last chunk there could be, and one more than there is */
    assert(host_ask(&drive, ask, sizeof ask, answer, sizeof answer) == 11);
    assert(bt_get_u32(answer + 2) == BT_ABORT_VALUE_HIGH);
    memset(ask + 3, 0, 4);
    arm(10, 1, 0, BT_CAPTURE_TRIGGER_IMMEDIATE);
    run(10);
    assert(host_ask(&drive, ask, sizeof ask, answer, sizeof answer) == 11);
    assert(bt_get_u32(answer + 2) == BT_ABORT_DEVICE_STATE);
}

/* Streams `ticks`, with a main loop that comes every `every` ticks; every record is in a batch or dropped. */
static void check_stream(uint16_t stride, uint8_t batch, unsigned ticks, unsigned every)
{
    uint8_t start[15] = { BT_STREAM, 1 }, stop[7] = { BT_STREAM, 2 }, answer[BT_MAX_REPLY];
    uint32_t records = 0, next_tick = 0, sequence = 0, missing = 0;
    unsigned done;
    size_t n;
    check_power_up(&drive);
    run(3);
    bt_put_u16(start + 2, stride);
    start[4] = batch;
    start[6] = 2;
    bt_put_u32(start + 7, MAPPING_TICK);
    bt_put_u32(start + 11, MAPPING_TORQUE);
    host_nmt(&drive, BT_NMT_START);
    assert(host_ask(&drive, start, sizeof start, answer, sizeof answer) == 16 && bt_get_u32(answer + 2) == BT_OK);
    next_tick = (3u / stride + 1u) * stride;
    for (done = 0; done < ticks; done += every) {
        run(every);
        if (done + every < ticks)
            bt_poll(&drive);
        else
            host_send(&drive, stop, sizeof stop);
        while ((n = host_hear(&drive, answer, sizeof answer)) > 0) {
            uint32_t k;
            if (answer[0] == BT_HEARTBEAT)
                continue;
            if (answer[0] != BT_BATCH)
                break;
            if (bt_get_u32(answer + 3) != sequence)
                assert(bt_get_u32(answer + 7) > next_tick);
            missing += (bt_get_u32(answer + 7) - next_tick) / stride;
            next_tick = bt_get_u32(answer + 7);
            sequence = bt_get_u32(answer + 3) + 1u;
            assert(answer[13] >= 1 && answer[13] <= batch && n == 14u + answer[13] * 8u);
            for (k = 0; k < answer[13]; k++, next_tick += stride) {
                assert(bt_get_u32(answer + 14 + 8 * k) == next_tick);
                assert(bt_float_of(bt_get_u32(answer + 18 + 8 * k)) == (float)next_tick);
            }
            records += answer[13];
        }
    }
    assert(answer[0] == BT_STREAM + BT_ANSWER && bt_get_u16(answer + 6) == 1);
    assert(bt_get_u32(answer + 8) == (3u + ticks) / stride - 3u / stride);
    assert(bt_get_u32(answer + 12) == bt_get_u32(answer + 8) - records && missing <= bt_get_u32(answer + 12));
    if (every <= 100)
        assert(missing == 0 && bt_get_u32(answer + 12) == 0);
    else
        assert(missing > 0);
}

/* A line that nobody drains: telemetry is dropped first, then answers; what was taken comes out whole. */
static void check_full_line(void)
{
    uint8_t start[11] = { BT_STREAM, 1, 1, 0, 50, 0, 1 }, read[5] = { BT_READ, 0 }, answer[BT_MAX_REPLY];
    unsigned batches = 0, replies = 0, sent;
    size_t n;
    check_power_up(&drive);
    assert(host_write(&drive, BT_ID_producer_heartbeat, 0) == BT_OK);
    bt_put_u32(start + 7, MAPPING_TICK);
    host_nmt(&drive, BT_NMT_START);
    assert(host_ask(&drive, start, sizeof start, answer, sizeof answer) == 16);
    for (sent = 0; sent < 100; sent++) {
        run(50);
        bt_poll(&drive);
    }
    bt_put_u16(read + 2, bt_entries[BT_ID_R_s].index);
    read[4] = bt_entries[BT_ID_R_s].sub;
    for (sent = 0; sent < 200; sent++) {
        read[1] = (uint8_t)sent;
        host_send(&drive, read, sizeof read);
    }
    while ((n = host_hear(&drive, answer, sizeof answer)) > 0) {
        if (answer[0] == BT_BATCH) {
            assert(replies == 0 && n == 14 + 200);
            batches++;
        } else {
            assert(answer[0] == BT_READ + BT_ANSWER && answer[1] == replies);
            replies++;
        }
    }
    assert(batches > 5 && batches < BT_TX_BYTES / 200u);
    assert(replies >= BT_TX_RESERVE / 24u && replies < 200);
}

void check_records(void)
{
    check_capture(100, 1, 0, 5);
    check_capture(100, 1, 40, 60);
    check_capture(100, 1, 40, 7);
    check_capture(100, 1, 99, 1000);
    check_capture(100, 7, 40, 1001);
    check_capture(BT_CAPTURE_WORDS / 2u, 1, 1, 3);
    check_end_of_upload();
    check_stream(1, 20, 1000, 10);
    check_stream(1, 7, 1001, 13);
    check_stream(25, 4, 1000, 10);
    check_stream(1, 20, 4000, 2000);
    check_full_line();
    printf("records: captures around a trigger, streams with and without a slow main loop\n");
}
