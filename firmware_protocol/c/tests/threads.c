/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A drive whose interrupts are threads, for ThreadSanitizer: control, a break input, both lines in and out, the main
 * loop. Two hosts arm captures, stream, remap process data, enable, halt and read everything, in no order, while
 * control ticks. What is looked at besides races: that streamed records are of the ticks they say. */
#undef NDEBUG
#include <assert.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "benchtool.h"
#include "bt_bytes.h"
#include "bt_canopen.h"
#include "bt_sync.h"

#define TICKS 2500u /* at least, and until everything has been seen */
#define MOST_TICKS 1000000u
#define WRAP_AFTER 500u
#define MAPPING_TICK 0x20300120u

static struct bt_drive drive;
static struct bt_can can;
static volatile bool over;
static volatile uint8_t upload; /* the number of the last one that was opened */

/* What was seen, and how far the threads are: counts that order nothing, so that they hide no race. */
static unsigned batches, chunks, process_data, sdo_answers, breaks, ticks_enabled, ticks, polls;

static void count(unsigned *of)
{
    __atomic_fetch_add(of, 1u, __ATOMIC_RELAXED);
}

static unsigned seen(const unsigned *of)
{
    return __atomic_load_n(of, __ATOMIC_RELAXED);
}

static bool all_seen(void)
{
    return seen(&batches) > 0 && seen(&process_data) > 0 && seen(&sdo_answers) > 0 && seen(&breaks) > 0 &&
           seen(&ticks_enabled) > 0;
}

/* Lets another thread get on, if it runs at all: on a busy machine giving the processor away costs milliseconds. */
static void wait_for(const unsigned *progress)
{
    const unsigned before = seen(progress);
    unsigned patience = 2000;
    while (patience-- > 0 && seen(progress) == before) {
    }
}

/* ---- the lock ------------------------------------------------------------------------------------------- */

static pthread_mutex_t mutex;
static pthread_t main_thread; /* which runs the main loop */

static void make_lock(void)
{
    pthread_mutexattr_t kind;
    assert(pthread_mutexattr_init(&kind) == 0);
    assert(pthread_mutexattr_settype(&kind, PTHREAD_MUTEX_ERRORCHECK) == 0);
    assert(pthread_mutex_init(&mutex, &kind) == 0);
}

void pthread_lock_take(void)
{
    assert(pthread_mutex_lock(&mutex) == 0);
}

/* Every third time the main loop gives the lock back it lets a tick pass, so that what it goes on to touch without the
 * lock meets one. */
void pthread_lock_give(void)
{
    static unsigned given;
    const bool is_main = pthread_equal(main_thread, pthread_self());
    const bool waits = is_main && ++given % 3u == 0;
    assert(pthread_mutex_unlock(&mutex) == 0);
    if (waits) {
        const unsigned before = seen(&ticks);
        unsigned patience = 10;
        while (patience-- > 0 && seen(&ticks) == before)
            sched_yield();
    }
}

/* ---- control -------------------------------------------------------------------------------------------- */

static void control_tick(unsigned k)
{
    struct bt_variables *v = bt_variables(&drive);
    v->i_a = (float)k;
    v->omega_m += 0.01f * (bt_omega_m_setpoint(&drive) - v->omega_m);
    v->torque = v->torque_reference = bt_is_halted(&drive) ? 0.0f : bt_torque_setpoint(&drive);
    v->u_dc = v->u_dc_max * 0.5f;
    if (bt_may_switch(&drive))
        count(&ticks_enabled);
    if (bt_is_quick_stopping(&drive) && k % 16u == 0)
        bt_standstill(&drive);
    if (k % 997u == 0)
        bt_trip(&drive, BT_ERROR_OVERSPEED);
    bt_tick(&drive);
    bt_can_tick(&can);
}

static void *control(void *unused)
{
    unsigned k;
    for (k = 0; k < TICKS || !all_seen(); k++) {
        assert(k < MOST_TICKS);
        BT_LOCK();
        control_tick(k);
        BT_UNLOCK();
        count(&ticks);
        wait_for(&polls);
    }
    BT_STORE(&over, true);
    return unused;
}

static void *break_input(void *unused)
{
    unsigned k;
    for (k = 0; !BT_LOAD(&over); k++) {
        if (k % 1024u == 0) {
            bt_trip(&drive, BT_ERROR_OVERCURRENT);
            count(&breaks);
        }
        sched_yield();
    }
    return unused;
}

/* ---- a host on each line -------------------------------------------------------------------------------- */

struct chance {
    uint32_t state;
};

static uint32_t draw(struct chance *chance, uint32_t below)
{
    chance->state = chance->state * 1664525u + 1013904223u;
    return (chance->state >> 8) % below;
}

static uint16_t draw_controlword(struct chance *chance)
{
    static const uint16_t words[] = { 6, 7, 15, 15, 0x10F, 15, 2, 0, 0x80 };
    return words[draw(chance, sizeof words / sizeof words[0])];
}

static void put_place(uint8_t *at, enum bt_id id)
{
    bt_put_u16(at, bt_entries[id].index);
    at[2] = bt_entries[id].sub;
}

static void serial_send(const uint8_t *payload, size_t n)
{
    static uint8_t data[4096], frame[4096];
    struct bt_ring line;
    size_t length, sent = 0;
    bt_ring_init(&line, data, sizeof data);
    assert(bt_frame_send(&line, payload, n, 0));
    length = bt_ring_get(&line, frame, sizeof frame);
    while (sent < length && !BT_LOAD(&over)) {
        sent += bt_receive(&drive, frame + sent, length - sent);
        sched_yield();
    }
}

static void serial_write(enum bt_id id, uint32_t value)
{
    uint8_t message[9] = { BT_WRITE, 1 };
    put_place(message + 2, id);
    bt_put_u32(message + 5, value);
    serial_send(message, 5u + bt_entries[id].size);
}

/* All that leads out of a fault to switching: words in no order hardly ever do. */
static void serial_enable(void)
{
    static const uint8_t words[] = { 0, 0x80, 6, 7, 15 };
    size_t k;
    for (k = 0; k < sizeof words; k++)
        serial_write(BT_ID_controlword, words[k]);
}

static void serial_step(struct chance *chance)
{
    static uint32_t sequence;
    uint8_t message[32] = { 0 };
    switch (draw(chance, 13)) {
    case 0:
        serial_write(BT_ID_capture_channel_1, MAPPING_TICK);
        serial_write(BT_ID_capture_rows, 1u + draw(chance, 30));
        serial_write(BT_ID_capture_stride, 1u + draw(chance, 3));
        serial_write(BT_ID_capture_trigger, draw(chance, 5));
        serial_write(BT_ID_capture_pretrigger, draw(chance, 2));
        serial_write(BT_ID_capture_control, draw(chance, 8) > 0);
        break;
    case 1:
        message[0] = BT_STREAM;
        bt_put_u16(message + 2, (uint16_t)draw(chance, 4)); /* 0 stops */
        message[4] = (uint8_t)(1u + draw(chance, 20));
        message[6] = 1;
        bt_put_u32(message + 7, MAPPING_TICK);
        serial_send(message, 11);
        break;
    case 2:
        message[0] = BT_OPEN;
        put_place(message + 2, BT_ID_capture_data);
        serial_send(message, 5);
        break;
    case 11:
        message[0] = BT_CHUNKS;
        message[2] = BT_LOAD(&upload);
        bt_put_u16(message + 7, 1);
        serial_send(message, 9);
        break;
    case 3:
        message[0] = BT_SETPOINT;
        bt_put_u32(message + 1, ++sequence);
        bt_put_u32(message + 5, bt_word_of((float)draw(chance, 100) * 1e-3f));
        bt_put_u32(message + 9, bt_word_of((float)draw(chance, 10)));
        serial_send(message, 13);
        break;
    case 4:
        message[0] = BT_HOST_HEARTBEAT;
        message[1] = 127;
        message[2] = 5;
        serial_send(message, 3);
        break;
    case 5:
        message[0] = BT_NMT;
        message[1] = draw(chance, 8) > 0 ? BT_NMT_START : draw(chance, 2) ? BT_NMT_ENTER_PRE_OPERATIONAL
                                                                         : BT_NMT_RESET_NODE;
        serial_send(message, 2);
        break;
    case 6:
        serial_write(BT_ID_mode_of_operation, 3u + draw(chance, 2));
        break;
    case 7:
        serial_write(BT_ID_host_heartbeat, draw(chance, 2) ? (uint32_t)127 << 16 | 2000u : 0);
        break;
    case 8:
        serial_write(BT_ID_R_s, bt_word_of(0.5f));
        serial_write(BT_ID_store_all, 0x65766173u);
        break;
    case 9:
        serial_enable();
        break;
    case 10:
        serial_write(BT_ID_controlword, draw_controlword(chance));
        break;
    default:
        message[0] = BT_READ;
        put_place(message + 2, (enum bt_id)draw(chance, BT_ENTRY_COUNT));
        serial_send(message, 5);
        break;
    }
}

static void *serial_in(void *unused)
{
    struct chance chance = { 1 };
    while (!BT_LOAD(&over))
        serial_step(&chance);
    return unused;
}

static void take_payload(const uint8_t *payload)
{
    unsigned k;
    if (payload[0] == BT_CHUNKS + BT_ANSWER && bt_get_u32(payload + 2) == BT_OK)
        count(&chunks);
    if (payload[0] == BT_OPEN + BT_ANSWER && bt_get_u32(payload + 2) == BT_OK)
        BT_STORE(&upload, payload[9]);
    if (payload[0] != BT_BATCH)
        return;
    count(&batches);
    for (k = 0; k < payload[13]; k++)
        assert(bt_get_u32(payload + 14 + 4 * k) == bt_get_u32(payload + 7) + k * bt_get_u16(payload + 11));
}

static void *serial_out(void *unused)
{
    static struct bt_receiver receiver;
    uint8_t data[256];
    size_t n, k;
    bt_receiver_init(&receiver, BT_MAX_REQUEST);
    while (!BT_LOAD(&over)) {
        n = bt_transmit(&drive, data, sizeof data);
        for (k = 0; k < n; k++) {
            if (bt_receiver_take(&receiver, data[k]) > 0)
                take_payload(receiver.data);
        }
        sched_yield();
    }
    assert(bt_receiver_dropped(&receiver) == 0);
    return unused;
}

static void can_send(uint16_t id, const uint8_t *data, size_t n)
{
    while (!BT_LOAD(&over) && !bt_can_receive(&can, id, data, n))
        sched_yield();
}

static void sdo(uint8_t command, enum bt_id id, uint32_t value)
{
    uint8_t data[8] = { 0 };
    data[0] = command;
    put_place(data + 1, id);
    bt_put_u32(data + 4, value);
    can_send(0x601, data, sizeof data);
}

static void sdo_write(enum bt_id id, uint32_t value)
{
    sdo((uint8_t)(0x23u | (4u - bt_entries[id].size) << 2), id, value);
}

static void remap(struct chance *chance)
{
    const unsigned number = draw(chance, 3);
    const unsigned c = number * (BT_ID_tpdo2_cob_id - BT_ID_tpdo1_cob_id);
    const unsigned m = number * (BT_ID_tpdo2_mapping_count - BT_ID_tpdo1_mapping_count);
    static const enum bt_id mapped[] = { BT_ID_tick, BT_ID_stream_sequence, BT_ID_statusword, BT_ID_omega_m,
                                         BT_ID_velocity_actual, BT_ID_rpdo_dropped, BT_ID_error_code };
    const enum bt_id id = mapped[draw(chance, sizeof mapped / sizeof mapped[0])];
    sdo_write((enum bt_id)(BT_ID_tpdo1_cob_id + c), 0x80000190u + number);
    sdo_write((enum bt_id)(BT_ID_tpdo1_event_timer + c), 1u + draw(chance, 3));
    sdo_write((enum bt_id)(BT_ID_tpdo1_mapping_count + m), 0);
    sdo_write((enum bt_id)(BT_ID_tpdo1_mapping_1 + m), bt_mapping(&bt_entries[id]));
    sdo_write((enum bt_id)(BT_ID_tpdo1_mapping_count + m), 1);
    sdo_write((enum bt_id)(BT_ID_tpdo1_cob_id + c), 0x190u + number);
}

static void can_step(struct chance *chance)
{
    static const uint8_t heartbeat = 5, begin[8] = { 0xA3 }, acknowledgement[8] = { 0xA2, 7, 20 };
    uint8_t data[8] = { 0 };
    switch (draw(chance, 7)) {
    case 0:
    case 1:
        remap(chance);
        break;
    case 2:
        can_send(0x77F, &heartbeat, 1);
        break;
    case 3:
        bt_put_u32(data, bt_word_of(0.01f));
        bt_put_u32(data + 4, bt_word_of((float)draw(chance, 10)));
        can_send(0x201, data, sizeof data);
        break;
    case 4:
        sdo_write(BT_ID_controlword, draw_controlword(chance));
        break;
    case 5:
        sdo(0xA4, BT_ID_capture_data, 20);
        can_send(0x601, begin, sizeof begin);
        can_send(0x601, acknowledgement, sizeof acknowledgement);
        break;
    default:
        sdo(0x40, (enum bt_id)draw(chance, BT_ENTRY_COUNT), 0);
        break;
    }
}

static void *can_in(void *unused)
{
    struct chance chance = { 2 };
    while (!BT_LOAD(&over))
        can_step(&chance);
    return unused;
}

static void *can_out(void *unused)
{
    struct bt_can_frame frame;
    while (!BT_LOAD(&over)) {
        while (bt_can_transmit(&can, &frame)) {
            if (frame.id >= 0x190u && frame.id < 0x193u)
                count(&process_data);
            if (frame.id == 0x581u)
                count(&sdo_answers);
        }
        sched_yield();
    }
    return unused;
}

/* ---- the main loop -------------------------------------------------------------------------------------- */

static void main_loop(void)
{
    while (!BT_LOAD(&over)) {
        bt_poll(&drive);
        bt_can_poll(&can);
        count(&polls);
    }
}

int main(void)
{
    static void *(*const parts[])(void *) = { control, break_input, serial_in, serial_out, can_in, can_out };
    enum { PARTS = sizeof parts / sizeof parts[0] };
    struct bt_config config = { 0 };
    pthread_t threads[PARTS];
    unsigned k;
    main_thread = pthread_self();
    make_lock();
    config.tick_period_ns = 1000000u;
    config.node_id = 1;
    config.first_tick = 0u - WRAP_AFTER;
    bt_init(&drive, &config);
    bt_can_init(&can, &drive.node);
    for (k = 0; k < PARTS; k++)
        assert(pthread_create(&threads[k], NULL, parts[k], NULL) == 0);
    main_loop();
    for (k = 0; k < PARTS; k++)
        assert(pthread_join(threads[k], NULL) == 0);
    printf("threads: %u ticks, %u of them enabled, %u batches, %u chunks, %u process data, %u answers, %u breaks, "
           "%u captures\n",
           ticks, ticks_enabled, batches, chunks, process_data, sdo_answers, breaks,
           (unsigned)drive.node.device.capture.sequence);
    return 0;
}
