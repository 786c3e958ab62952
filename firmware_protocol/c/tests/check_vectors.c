/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The golden vectors of the protocol. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "bt_crc.h"
#include "check.h"
#include "host.h"
#include "vectors.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static struct bt_drive drive;

static void check_crc(void)
{
    size_t k, cut;
    for (k = 0; k < COUNT(crc_vectors); k++) {
        const struct crc_vector *each = &crc_vectors[k];
        for (cut = 0; cut <= each->data.n; cut++) {
            const uint32_t begun = bt_crc(0, each->data.data, cut);
            assert(bt_crc(begun, each->data.data + cut, each->data.n - cut) == each->crc);
        }
    }
}

/* From every place of a ring, so that codes and data meet its end. */
static void check_cobs(void)
{
    uint8_t ring[1024], flat[1024];
    size_t k, j;
    uint32_t at;
    for (k = 0; k < COUNT(cobs_vectors); k++) {
        const struct cobs_vector *each = &cobs_vectors[k];
        for (at = 0xFFFFFF00u; at != 0x400u; at++) {
            struct bt_cobs_encoder encoder;
            bt_cobs_begin(&encoder, ring, sizeof ring - 1u, at);
            bt_cobs_put(&encoder, each->plain.data, each->plain.n);
            assert(bt_cobs_end(&encoder) - at == each->stuffed.n);
            for (j = 0; j < each->stuffed.n; j++)
                assert(ring[(at + j) & (sizeof ring - 1u)] == each->stuffed.data[j]);
        }
        assert(each->stuffed.n <= BT_COBS_LONGEST(each->plain.n));
        memcpy(flat, each->stuffed.data, each->stuffed.n);
        assert(bt_cobs_decode(flat, each->stuffed.n) == each->plain.n);
        assert(memcmp(flat, each->plain.data, each->plain.n) == 0);
    }
}

static void check_frames(void)
{
    static uint8_t data[8192], out[8192];
    struct bt_ring line;
    size_t k;
    for (k = 0; k < COUNT(message_vectors); k++) {
        const struct message_vector *each = &message_vectors[k];
        bt_ring_init(&line, data, sizeof data);
        assert(bt_frame_send(&line, each->payload.data, each->payload.n, 0));
        assert(bt_ring_get(&line, out, sizeof out) == each->frame.n);
        assert(memcmp(out, each->frame.data, each->frame.n) == 0);
    }
}

static void check_lines(void)
{
    static struct bt_receiver receiver;
    size_t k, j;
    for (k = 0; k < COUNT(line_vectors); k++) {
        const struct line_vector *each = &line_vectors[k];
        const uint8_t *expected = each->payloads.data;
        size_t count = 0;
        bt_receiver_init(&receiver, each->max_payload);
        for (j = 0; j < each->data.n; j++) {
            const size_t n = bt_receiver_take(&receiver, each->data.data[j]);
            if (n > 0) {
                assert(count < each->count && n == each->lengths[count++]);
                assert(memcmp(receiver.data, expected, n) == 0);
                expected += n;
            }
        }
        assert(count == each->count && receiver.frames == count);
        assert(receiver.too_long == each->dropped[0] && receiver.bad_stuffing == each->dropped[1]);
        assert(receiver.too_short == each->dropped[2] && receiver.bad_crc == each->dropped[3]);
    }
}

static void check_requests(void)
{
    uint8_t answer[BT_MAX_REPLY];
    size_t k;
    for (k = 0; k < COUNT(request_vectors); k++) {
        const struct request_vector *each = &request_vectors[k];
        check_power_up(&drive);
        assert(host_ask(&drive, each->payload.data, each->payload.n, answer, sizeof answer) == each->answer.n);
        assert(memcmp(answer, each->answer.data, each->answer.n) == 0);
        assert(host_read(&drive, BT_ID_serial_dropped) == 1);
    }
}

static void set_point(uint32_t sequence, float torque)
{
    uint8_t message[13] = { BT_SETPOINT };
    bt_put_u32(message + 1, sequence);
    bt_put_u32(message + 5, bt_word_of(torque));
    host_send(&drive, message, sizeof message);
}

static void check_sequences(void)
{
    size_t k;
    for (k = 0; k < COUNT(sequence_vectors); k++) {
        const struct sequence_vector *each = &sequence_vectors[k];
        check_power_up(&drive);
        host_nmt(&drive, BT_NMT_START);
        if (each->has_last)
            set_point(each->last, 0.5f);
        set_point(each->sequence, 1.5f);
        assert((host_read(&drive, BT_ID_torque_command) == bt_word_of(1.5f)) == each->taken);
        assert(host_read(&drive, BT_ID_rpdo_dropped) == (each->taken ? 0u : 1u));
    }
}

static void check_scaled(void)
{
    size_t k;
    for (k = 0; k < COUNT(scaled_vectors); k++)
        assert(bt_stream_scaled(scaled_vectors[k].value, scaled_vectors[k].scale) == scaled_vectors[k].raw);
    assert(bt_stream_scaled(0.49999997f, 1.0f) == 0);
}

void check_vectors(void)
{
    check_crc();
    check_cobs();
    check_frames();
    check_lines();
    check_requests();
    check_sequences();
    check_scaled();
    printf("vectors: %u stuffings, %u frames, %u lines, %u requests\n", (unsigned)COUNT(cobs_vectors),
           (unsigned)COUNT(message_vectors), (unsigned)COUNT(line_vectors), (unsigned)COUNT(request_vectors));
}
