/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_stream.h"

#include "bt_bytes.h"
#include "bt_sync.h"

#define NO_VALUE INT16_MIN

/* Entries that memory does not hold: the library makes them when they are read. */
static bool is_computed(enum bt_id id)
{
    switch (id) {
    case BT_ID_statusword:
    case BT_ID_velocity_actual:
    case BT_ID_torque_actual:
    case BT_ID_current_actual:
    case BT_ID_dc_link_voltage:
    case BT_ID_motor_rated_torque:
        return true;
    default:
        return false;
    }
}

uint32_t bt_stream_layout(const uint8_t *message, struct bt_stream_layout *layout)
{
    const uint8_t n = message[6];
    const size_t value_bytes = message[5] == 0 ? 4u : 2u;
    unsigned k;
    layout->stride = bt_get_u16(message + 2);
    layout->batch = message[4];
    layout->scaled = message[5] != 0;
    layout->channels = n;
    if (layout->batch == 0 || n == 0)
        return BT_ABORT_VALUE_LOW;
    if (n > BT_STREAM_CHANNELS)
        return BT_ABORT_VALUE_HIGH;
    for (k = 0; k < n; k++) {
        const uint32_t mapping = bt_get_u32(message + 7 + 4 * k);
        const struct bt_entry *entry;
        enum bt_id id;
        if (bt_find((uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), &id) != BT_OK)
            return BT_ABORT_NO_OBJECT;
        entry = &bt_entries[id];
        if (bt_mapping(entry) != mapping || entry->size != 4u || !bt_is_mappable(entry) ||
            entry->access == BT_ACCESS_WO || is_computed(id))
            return BT_ABORT_NOT_MAPPABLE;
        layout->offsets[k] = entry->offset;
        layout->types[k] = entry->type;
    }
    for (k = 0; layout->scaled && k < n; k++) {
        const float scale = bt_float_of(bt_get_u32(message + 7 + 4u * n + 4u * k));
        if (!bt_is_finite(scale) || !(scale > 0.0f))
            return BT_ABORT_VALUE;
        layout->scales[k] = scale;
    }
    return BT_BATCH_HEADER_BYTES + layout->batch * n * value_bytes > BT_MAX_REPLY ? BT_ABORT_MAPPING_TOO_LONG : BT_OK;
}

void bt_stream_begin(struct bt_stream *stream, const struct bt_stream_layout *layout)
{
    stream->layout = *layout;
    stream->configured = true;
    stream->schema++;
    stream->sequence = 0;
    stream->sent = 0;
    stream->dropped = 0;
}

/* The tick goes on while this computes: what has passed meanwhile is left out with the lock held. */
void bt_stream_resume(struct bt_stream *stream, const struct bt_device *device)
{
    const uint32_t stride = stream->layout.stride;
    uint32_t next;
    if (!stream->configured || stream->running)
        return;
    next = (uint32_t)((bt_device_ticks(device) / stride + 1u) * stride);
    stream->slots = BT_STREAM_WORDS / (stream->layout.channels + 1u);
    stream->write_slot = stream->read_slot = 0;
    stream->head = stream->tail = 0;
    stream->due = stream->accounted = 0;
    BT_LOCK();
    while ((int32_t)(next - device->variables.tick) <= 0)
        next += stride;
    stream->next_tick = next;
    stream->running = true;
    BT_UNLOCK();
    stream->expected_tick = next;
}

/* ---- in the control interrupt --------------------------------------------------------------------------- */

void bt_stream_tick(struct bt_stream *stream, const struct bt_variables *variables)
{
    uint32_t *row;
    unsigned k;
    if (!stream->running || variables->tick != stream->next_tick)
        return;
    stream->next_tick += stream->layout.stride;
    stream->due = stream->due + 1u;
    if (stream->head - BT_LOAD(&stream->tail) == stream->slots)
        return;
    row = &stream->words[stream->write_slot * (stream->layout.channels + 1u)];
    *row++ = variables->tick;
    for (k = 0; k < stream->layout.channels; k++)
        memcpy(row++, (const uint8_t *)variables + stream->layout.offsets[k], 4);
    stream->write_slot = stream->write_slot + 1u < stream->slots ? stream->write_slot + 1u : 0u;
    BT_STORE(&stream->head, stream->head + 1u);
}

/* ---- batches -------------------------------------------------------------------------------------------- */

int16_t bt_stream_scaled(float value, float scale)
{
    const float steps = value / scale;
    int32_t whole;
    if (!(steps > -32767.5f && steps < 32767.5f))
        return NO_VALUE;
    whole = (int32_t)steps;
    if (steps - (float)whole >= 0.5f)
        whole++;
    else if (steps - (float)whole <= -0.5f)
        whole--;
    return (int16_t)whole;
}

static float value_of(uint32_t word, uint8_t type)
{
    switch (type) {
    case BT_TYPE_F32:
        return bt_float_of(word);
    case BT_TYPE_I32:
        return (float)(int32_t)word;
    default:
        return (float)word;
    }
}

static uint8_t *put_record(const struct bt_stream_layout *layout, const uint32_t *values, uint8_t *at)
{
    unsigned k;
    for (k = 0; k < layout->channels; k++) {
        if (layout->scaled) {
            const float value = value_of(values[k], layout->types[k]);
            bt_put_u16(at, (uint16_t)bt_stream_scaled(value, layout->scales[k]));
            at += 2;
        } else {
            bt_put_u32(at, values[k]);
            at += 4;
        }
    }
    return at;
}

static void count(struct bt_stream *stream, uint32_t records, bool was_sent)
{
    stream->sequence++;
    stream->sent += records;
    stream->accounted += records;
    if (!was_sent)
        stream->dropped += records;
}

static const uint32_t *oldest(const struct bt_stream *stream)
{
    return &stream->words[stream->read_slot * (stream->layout.channels + 1u)];
}

static uint32_t waiting_records(const struct bt_stream *stream)
{
    return BT_LOAD(&stream->head) - stream->tail;
}

/* A batch of the records that wait, up to the first one that is missing. */
static void send_batch(struct bt_stream *stream, uint8_t *buffer, bt_send_batch send, void *context)
{
    const uint32_t stride = stream->layout.stride;
    uint8_t *at = buffer + BT_BATCH_HEADER_BYTES;
    const uint32_t first_tick = oldest(stream)[0];
    uint32_t waiting = waiting_records(stream);
    uint8_t n = 0;
    if (first_tick != stream->expected_tick)
        count(stream, (first_tick - stream->expected_tick) / stride, false);
    while (n < stream->layout.batch && waiting > 0 && oldest(stream)[0] == first_tick + n * stride) {
        at = put_record(&stream->layout, oldest(stream) + 1, at);
        stream->read_slot = stream->read_slot + 1u < stream->slots ? stream->read_slot + 1u : 0u;
        BT_STORE(&stream->tail, stream->tail + 1u);
        waiting--;
        n++;
    }
    stream->expected_tick = first_tick + n * stride;
    buffer[0] = 0x42;
    bt_put_u16(buffer + 1, stream->schema);
    bt_put_u32(buffer + 3, stream->sequence);
    bt_put_u32(buffer + 7, first_tick);
    bt_put_u16(buffer + 11, stream->layout.stride);
    buffer[13] = n;
    count(stream, n, send(context, buffer, (size_t)(at - buffer)));
}

void bt_stream_transmit(struct bt_stream *stream, unsigned most, uint8_t *buffer, bt_send_batch send, void *context)
{
    /* A batch longer than the ring goes out when the ring is half full. */
    const uint32_t half = stream->slots / 2u;
    const uint32_t enough = stream->layout.batch < half ? stream->layout.batch : half;
    while (stream->running && most-- > 0 && waiting_records(stream) >= enough)
        send_batch(stream, buffer, send, context);
}

void bt_stream_pause(struct bt_stream *stream, uint8_t *buffer, bt_send_batch send, void *context)
{
    if (!stream->running)
        return;
    BT_LOCK();
    stream->running = false;
    BT_UNLOCK();
    while (waiting_records(stream) > 0)
        send_batch(stream, buffer, send, context);
    if (stream->due != stream->accounted)
        count(stream, stream->due - stream->accounted, false);
}
