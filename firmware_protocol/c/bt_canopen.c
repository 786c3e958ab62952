/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_canopen.h"

#include "bt_bytes.h"
#include "bt_sync.h"

#define ID_NMT 0x000u
#define ID_EMERGENCY 0x080u
#define ID_SDO_ANSWER 0x580u
#define ID_SDO_REQUEST 0x600u
#define ID_HEARTBEAT 0x700u
#define NODES 0x80u

/* ---- rings of frames ------------------------------------------------------------------------------------ */

static void ring_init(struct bt_can_ring *ring, struct bt_can_frame *frames, uint32_t size)
{
    ring->mask = size - 1u;
    ring->frames = frames;
}

static uint32_t room(const struct bt_can_ring *ring)
{
    return ring->mask + 1u - (BT_LOAD(&ring->head) - BT_LOAD(&ring->tail));
}

static bool put(struct bt_can_ring *ring, const struct bt_can_frame *frame)
{
    if (room(ring) == 0) {
        ring->lost++;
        return false;
    }
    ring->frames[ring->head & ring->mask] = *frame;
    BT_STORE(&ring->head, ring->head + 1u);
    return true;
}

/* The frame that is next, or NULL. */
static const struct bt_can_frame *first(const struct bt_can_ring *ring)
{
    if (BT_LOAD(&ring->head) == ring->tail)
        return NULL;
    return &ring->frames[ring->tail & ring->mask];
}

static void drop_first(struct bt_can_ring *ring)
{
    BT_STORE(&ring->tail, ring->tail + 1u);
}

/* ---- to the bus ----------------------------------------------------------------------------------------- */

static void send(struct bt_can *can, uint32_t function, const uint8_t *data, uint8_t n)
{
    struct bt_can_frame frame;
    frame.id = (uint16_t)(function + can->node->device.config.node_id);
    frame.n = n;
    memcpy(frame.data, data, n);
    (void)put(&can->tx, &frame);
}

static void heartbeat(void *context, uint8_t state)
{
    send(context, ID_HEARTBEAT, &state, 1);
}

static void renew(struct bt_can *can)
{
    bt_tpdos_renew(&can->tpdos, &can->node->device);
}

static void boot(void *context)
{
    struct bt_can *can = context;
    bt_sdo_end(&can->sdo);
    renew(can);
    heartbeat(can, BT_NMT_BOOT_UP);
}

/* On CAN that has time until the next heartbeat. */
static void confirm(void *context, uint8_t state)
{
    (void)context;
    (void)state;
}

static void emergency(void *context, uint16_t code, uint8_t error_register)
{
    uint8_t data[8] = { 0 };
    bt_put_u16(data, code);
    data[2] = error_register;
    send(context, ID_EMERGENCY, data, sizeof data);
}

static void send_segments(struct bt_can *can)
{
    uint8_t segment[8];
    while (can->node->nmt_state != BT_NMT_STOPPED && room(&can->tx) > BT_CAN_TX_RESERVE &&
           bt_sdo_next(&can->sdo, segment))
        send(can, ID_SDO_ANSWER, segment, sizeof segment);
}

bool bt_can_transmit(struct bt_can *can, struct bt_can_frame *frame)
{
    const struct bt_can_frame *process_data = first(&can->pdo), *other = first(&can->tx);
    if (process_data != NULL && (other == NULL || process_data->id < other->id)) {
        *frame = *process_data;
        drop_first(&can->pdo);
    } else if (other != NULL) {
        *frame = *other;
        drop_first(&can->tx);
    } else {
        return false;
    }
    return true;
}

/* All that fall due in one tick, or none: a host could do nothing with some of them. */
void bt_can_tick(struct bt_can *can)
{
    struct bt_can_frame due[BT_TPDOS];
    const bool operational = BT_LOAD(&can->node->nmt_state) == BT_NMT_OPERATIONAL;
    const size_t n = bt_tpdos_tick(&can->tpdos, &can->node->device, operational, due);
    size_t k;
    if (room(&can->pdo) < n) {
        can->pdo.lost += (uint32_t)n;
        return;
    }
    for (k = 0; k < n; k++)
        (void)put(&can->pdo, &due[k]);
}

/* ---- from the bus --------------------------------------------------------------------------------------- */

bool bt_can_receive(struct bt_can *can, uint16_t id, const uint8_t *data, size_t n)
{
    struct bt_can_frame frame;
    if (n > sizeof frame.data)
        return false;
    frame.id = id;
    frame.n = (uint8_t)n;
    memcpy(frame.data, data, n);
    return put(&can->rx, &frame);
}

static void take_request(struct bt_can *can, const struct bt_can_frame *frame)
{
    uint8_t answer[8];
    bool answers;
    if (frame->n != sizeof answer || can->node->nmt_state == BT_NMT_STOPPED)
        return;
    answers = bt_sdo_take(&can->sdo, frame->data, answer);
    renew(can); /* no TPDO that was switched off is sent after the answer that says so */
    if (answers)
        send(can, ID_SDO_ANSWER, answer, sizeof answer);
}

static void handle(struct bt_can *can, const struct bt_can_frame *frame)
{
    struct bt_node *node = can->node;
    const uint8_t node_id = node->device.config.node_id;
    if (frame->id == ID_NMT) {
        if (frame->n == 2 && (frame->data[1] == 0 || frame->data[1] == node_id))
            bt_node_command(node, frame->data[0]);
    } else if (frame->id == ID_SDO_REQUEST + node_id) {
        take_request(can, frame);
    } else if (frame->id > ID_HEARTBEAT && frame->id < ID_HEARTBEAT + NODES) {
        if (frame->n == 1)
            bt_node_take_heartbeat(node, (uint8_t)(frame->id - ID_HEARTBEAT));
    } else if (node->nmt_state == BT_NMT_OPERATIONAL) {
        bt_rpdo_take(node, frame->id, frame->data, frame->n);
    }
}

void bt_can_init(struct bt_can *can, struct bt_node *node)
{
    const struct bt_line line = { can, boot, confirm, heartbeat, emergency };
    memset(can, 0, sizeof *can);
    can->node = node;
    bt_sdo_init(&can->sdo, &node->device);
    ring_init(&can->rx, can->rx_frames, BT_CAN_RX_FRAMES);
    ring_init(&can->tx, can->tx_frames, BT_CAN_TX_FRAMES);
    ring_init(&can->pdo, can->pdo_frames, BT_CAN_PDO_FRAMES);
    bt_node_add(node, &line);
}

void bt_can_poll(struct bt_can *can)
{
    uint32_t left = BT_LOAD(&can->rx.head) - can->rx.tail;
    renew(can); /* another line may have written the objects */
    for (; left > 0; left--) {
        const struct bt_can_frame frame = *first(&can->rx);
        drop_first(&can->rx);
        bt_device_look_after(&can->node->device); /* no frame undoes what the interrupt has found */
        handle(can, &frame);
    }
    send_segments(can);
}
