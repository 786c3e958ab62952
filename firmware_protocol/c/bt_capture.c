/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_capture.h"

#include "bt_bytes.h"
#include "bt_crc.h"
#include "bt_sync.h"

static const uint8_t magic[4] = { 'B', 'T', 'C', '1' };

/* The signal of a mapping, or BT_ID_NONE: captured are signals of four bytes. */
static enum bt_id signal_of(uint32_t mapping)
{
    enum bt_id id;
    if (bt_find((uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), &id) != BT_OK)
        return BT_ID_NONE;
    return bt_entries[id].role == BT_ROLE_SIGNAL && bt_entries[id].size == 4u && bt_mapping(&bt_entries[id]) == mapping
               ? id
               : BT_ID_NONE;
}

static uint32_t channel_mapping(const struct bt_variables *variables, unsigned channel)
{
    return bt_load(variables, (enum bt_id)(BT_ID_capture_channel_1 + channel)).u;
}

uint32_t bt_capture_check(const struct bt_variables *variables)
{
    const uint32_t rows = variables->capture_rows;
    unsigned channels;
    for (channels = 0; channels < BT_CAPTURE_CHANNELS; channels++) {
        const uint32_t mapping = channel_mapping(variables, channels);
        if (mapping == 0)
            break;
        if (signal_of(mapping) == BT_ID_NONE)
            return BT_ABORT_NOT_MAPPABLE;
    }
    if (channels == 0 || rows > BT_CAPTURE_WORDS / channels || variables->capture_pretrigger >= rows)
        return BT_ABORT_PARAMETER_INCOMPATIBLE;
    return signal_of(variables->capture_trigger_signal) == BT_ID_NONE ? BT_ABORT_NOT_MAPPABLE : BT_OK;
}

/* The level as integers, so that a count of more than 24 bits is compared exactly: value >= level is
 * value >= ceiling, value <= level is value <= floor. */
static void set_level(struct bt_capture *capture, float level)
{
    const float lowest = -1.0f, highest = 4294967296.0f;
    const float bounded = level < lowest ? lowest : level > highest ? highest : level;
    capture->level = level;
    capture->level_floor = (int64_t)bounded;
    if ((float)capture->level_floor > bounded)
        capture->level_floor--;
    capture->level_ceiling = capture->level_floor + ((float)capture->level_floor < bounded ? 1 : 0);
}

static void hand_over(struct bt_capture *capture)
{
    BT_LOCK();
    capture->state = BT_CAPTURE_STATE_ARMED;
    BT_UNLOCK();
}

void bt_capture_arm(struct bt_capture *capture, const struct bt_variables *variables)
{
    const enum bt_id trigger = signal_of(variables->capture_trigger_signal);
    uint8_t channels = 0;
    BT_LOCK();
    capture->state = BT_CAPTURE_STATE_IDLE;
    BT_UNLOCK();
    while (channels < BT_CAPTURE_CHANNELS) {
        const uint32_t mapping = channel_mapping(variables, channels);
        if (mapping == 0)
            break;
        capture->offsets[channels++] = bt_entries[signal_of(mapping)].offset;
    }
    capture->channels = channels;
    capture->rows = variables->capture_rows;
    capture->stride = variables->capture_stride;
    capture->until_row = 0;
    capture->pretrigger = variables->capture_pretrigger;
    capture->trigger = variables->capture_trigger;
    capture->trigger_offset = bt_entries[trigger].offset;
    capture->level_is_float = bt_entries[trigger].type == BT_TYPE_F32;
    set_level(capture, variables->capture_trigger_level);
    capture->compared = false;
    capture->last_torque_command = variables->torque_command;
    capture->last_omega_m_command = variables->omega_m_command;
    capture->position = 0;
    capture->rows_done = 0;
    capture->first_tick = 0;
    capture->trigger_tick = 0;
    capture->sealed = false;
    capture->sequence++;
    hand_over(capture);
}

void bt_capture_abort(struct bt_capture *capture)
{
    BT_LOCK();
    if (capture->state == BT_CAPTURE_STATE_ARMED || capture->state == BT_CAPTURE_STATE_TRIGGERED)
        capture->state = BT_CAPTURE_STATE_ABORTED;
    BT_UNLOCK();
}

bool bt_capture_is_complete(const struct bt_capture *capture, uint32_t sequence)
{
    bool complete;
    BT_LOCK();
    complete = capture->state == BT_CAPTURE_STATE_COMPLETE && capture->sequence == sequence;
    BT_UNLOCK();
    return complete;
}

/* ---- in the control interrupt --------------------------------------------------------------------------- */

static uint32_t word_at(const struct bt_variables *variables, uint16_t offset)
{
    uint32_t word;
    memcpy(&word, (const uint8_t *)variables + offset, sizeof word);
    return word;
}

static bool crosses(struct bt_capture *capture, uint32_t word, bool rising)
{
    bool hit;
    if (capture->level_is_float) {
        const float value = bt_float_of(word);
        hit = rising ? capture->last_value < capture->level && value >= capture->level
                     : capture->last_value > capture->level && value <= capture->level;
        capture->last_value = value;
    } else {
        const int64_t value = word;
        hit = rising ? capture->last_count < capture->level_ceiling && value >= capture->level_ceiling
                     : capture->last_count > capture->level_floor && value <= capture->level_floor;
        capture->last_count = value;
    }
    hit = hit && capture->compared;
    capture->compared = true;
    return hit;
}

static bool triggers(struct bt_capture *capture, const struct bt_variables *variables, bool tripped)
{
    bool hit;
    switch (capture->trigger) {
    case BT_CAPTURE_TRIGGER_IMMEDIATE:
        return true;
    case BT_CAPTURE_TRIGGER_SETPOINT:
        hit = variables->torque_command != capture->last_torque_command ||
              variables->omega_m_command != capture->last_omega_m_command;
        capture->last_torque_command = variables->torque_command;
        capture->last_omega_m_command = variables->omega_m_command;
        return hit;
    case BT_CAPTURE_TRIGGER_RISING:
    case BT_CAPTURE_TRIGGER_FALLING:
        return crosses(capture, word_at(variables, capture->trigger_offset),
                       capture->trigger == BT_CAPTURE_TRIGGER_RISING);
    case BT_CAPTURE_TRIGGER_FAULT:
        return tripped;
    default: /* a stimulus, which this library does not play */
        return false;
    }
}

void bt_capture_tick(struct bt_capture *capture, const struct bt_variables *variables, bool tripped)
{
    uint32_t *row;
    unsigned channel;
    if (capture->state != BT_CAPTURE_STATE_ARMED && capture->state != BT_CAPTURE_STATE_TRIGGERED)
        return;
    if (capture->state == BT_CAPTURE_STATE_ARMED && triggers(capture, variables, tripped)) {
        capture->trigger_tick = variables->tick;
        capture->first_tick = variables->tick + capture->until_row - capture->rows_done * capture->stride;
        capture->state = BT_CAPTURE_STATE_TRIGGERED;
    }
    if (capture->until_row > 0) {
        capture->until_row--;
        return;
    }
    capture->until_row = (uint16_t)(capture->stride - 1u);
    row = &capture->words[capture->position * capture->channels];
    for (channel = 0; channel < capture->channels; channel++)
        row[channel] = word_at(variables, capture->offsets[channel]);
    capture->position = capture->position + 1u < capture->rows ? capture->position + 1u : 0u;
    if (capture->state == BT_CAPTURE_STATE_ARMED) {
        if (capture->rows_done < capture->pretrigger)
            capture->rows_done++;
    } else if (++capture->rows_done == capture->rows) {
        capture->state = BT_CAPTURE_STATE_COMPLETE;
    }
}

/* ---- the data ------------------------------------------------------------------------------------------- */

size_t bt_capture_size(const struct bt_capture *capture)
{
    return BT_CAPTURE_HEADER_BYTES + (size_t)capture->rows * capture->channels * 4u;
}

/* Bytes of the rows; the oldest row is where the next one would go. */
static void read_rows(const struct bt_capture *capture, size_t from, uint8_t *data, size_t n)
{
    const size_t words = (size_t)capture->rows * capture->channels;
    size_t at = (size_t)capture->position * capture->channels + from / 4u;
    unsigned shift = (unsigned)(from % 4u) * 8u;
    if (at >= words)
        at -= words;
    while (n-- > 0) {
        *data++ = (uint8_t)(capture->words[at] >> shift);
        shift += 8u;
        if (shift == 32u) {
            shift = 0;
            at = at + 1u < words ? at + 1u : 0u;
        }
    }
}

static void seal(struct bt_capture *capture, uint32_t tick_period_ns)
{
    const size_t size = bt_capture_size(capture) - BT_CAPTURE_HEADER_BYTES;
    uint8_t piece[64];
    uint32_t crc;
    size_t from;
    memcpy(capture->header, magic, sizeof magic);
    bt_put_u16(capture->header + 4, capture->channels);
    bt_put_u16(capture->header + 6, capture->stride);
    bt_put_u32(capture->header + 8, tick_period_ns);
    bt_put_u32(capture->header + 12, capture->rows);
    bt_put_u32(capture->header + 16, capture->first_tick);
    bt_put_u32(capture->header + 20, capture->trigger_tick);
    bt_put_u32(capture->header + 24, capture->sequence);
    crc = bt_crc(0, capture->header, 28);
    for (from = 0; from < size; from += sizeof piece) {
        const size_t n = size - from < sizeof piece ? size - from : sizeof piece;
        read_rows(capture, from, piece, n);
        crc = bt_crc(crc, piece, n);
    }
    bt_put_u32(capture->header + 28, crc);
    capture->sealed = true;
}

void bt_capture_read(struct bt_capture *capture, uint32_t tick_period_ns, size_t from, uint8_t *data, size_t n)
{
    if (!capture->sealed)
        seal(capture, tick_period_ns);
    for (; n > 0 && from < BT_CAPTURE_HEADER_BYTES; n--)
        *data++ = capture->header[from++];
    if (n > 0)
        read_rows(capture, from - BT_CAPTURE_HEADER_BYTES, data, n);
}
