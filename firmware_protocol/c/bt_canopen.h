/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The drive on a CAN bus (CiA 301): network management, heartbeat, emergencies, SDO server and process data.
 *
 *     static struct bt_node node;                        bt_node_init before anything else
 *     static struct bt_can can;                          then bt_can_init(&can, &node)
 *
 *     control interrupt:   signals, bt_node_tick(&node), bt_can_tick(&can), in this order
 *     receive interrupt:   bt_can_receive(&can, id, data, n), of data frames with 11-bit identifiers
 *     transmit interrupt:  bt_can_transmit(&can, &frame)
 *     main loop:           bt_node_poll(&node), bt_can_poll(&can), at least every 10 ms
 *
 * The four may interrupt each other in any order, but none itself; threads in their place do as bt_sync.h says. A drive that has a serial line as well gives
 * the node of its struct bt_drive, and calls bt_tick and bt_poll in place of bt_node_tick and bt_node_poll. */
#ifndef BT_CANOPEN_H
#define BT_CANOPEN_H

#include "bt_canopen_pdo.h"
#include "bt_canopen_sdo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Frames that may arrive between two calls of bt_can_poll; all of these are powers of two. */
#ifndef BT_CAN_RX_FRAMES
#define BT_CAN_RX_FRAMES 16u
#endif

/* Frames that wait for the bus: answers, heartbeats and emergencies, and the segments of a block. */
#ifndef BT_CAN_TX_FRAMES
#define BT_CAN_TX_FRAMES 64u
#endif

/* Of these, what a block leaves to everything else. */
#ifndef BT_CAN_TX_RESERVE
#define BT_CAN_TX_RESERVE 8u
#endif

/* Process data that wait for the bus. */
#ifndef BT_CAN_PDO_FRAMES
#define BT_CAN_PDO_FRAMES 16u
#endif

#if (BT_CAN_RX_FRAMES & (BT_CAN_RX_FRAMES - 1)) || (BT_CAN_TX_FRAMES & (BT_CAN_TX_FRAMES - 1)) || \
    (BT_CAN_PDO_FRAMES & (BT_CAN_PDO_FRAMES - 1))
#error "the rings of frames must have a power of two"
#endif
#if BT_CAN_TX_FRAMES <= BT_CAN_TX_RESERVE
#error "a block must find room beside the reserve"
#endif
#if BT_CAN_PDO_FRAMES < 8
#error "eight TPDOs may fall due at once"
#endif

/* One writer and one reader; either may interrupt the other, as each alone moves its own counter. */
struct bt_can_ring {
    volatile uint32_t head; /* frames ever written */
    volatile uint32_t tail; /* frames ever read */
    uint32_t mask;
    uint32_t lost; /* that found it full */
    struct bt_can_frame *frames;
};

struct bt_can {
    struct bt_node *node;
    struct bt_sdo sdo;
    struct bt_tpdos tpdos;
    struct bt_can_ring rx; /* receive interrupt to main loop */
    struct bt_can_ring tx; /* main loop to transmit interrupt */
    struct bt_can_ring pdo; /* control interrupt to transmit interrupt */
    struct bt_can_frame rx_frames[BT_CAN_RX_FRAMES];
    struct bt_can_frame tx_frames[BT_CAN_TX_FRAMES];
    struct bt_can_frame pdo_frames[BT_CAN_PDO_FRAMES];
};

/* Stands the drive on a bus, and boots. */
void bt_can_init(struct bt_can *can, struct bt_node *node);

/* Keeps a frame for bt_can_poll; false if it is lost. */
bool bt_can_receive(struct bt_can *can, uint16_t id, const uint8_t *data, size_t n);

/* The next frame for the bus, the one of the lower identifier of those that wait; false if none does. */
bool bt_can_transmit(struct bt_can *can, struct bt_can_frame *frame);

/* Control interrupt: process data that are due. */
void bt_can_tick(struct bt_can *can);

/* Main loop: deal with what has come, and send what is due. */
void bt_can_poll(struct bt_can *can);

#ifdef __cplusplus
}
#endif

#endif
