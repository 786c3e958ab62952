/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The serial line in front of a node: every message of the protocol, version 1. */
#ifndef BT_SERVER_H
#define BT_SERVER_H

#include "bt_frame.h"
#include "bt_node.h"
#include "bt_upload.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_PROTOCOL_VERSION 1u

enum bt_message {
    BT_IDENTIFY = 0x01,
    BT_READ = 0x02,
    BT_WRITE = 0x03,
    BT_OPEN = 0x04,
    BT_CHUNKS = 0x05,
    BT_STREAM = 0x06,
    BT_LAST_REQUEST = 0x0F,
    BT_SETPOINT = 0x10,
    BT_HOST_HEARTBEAT = 0x11,
    BT_NMT = 0x12,
    BT_HEARTBEAT = 0x41,
    BT_BATCH = 0x42,
    BT_EVENT = 0x43,
    BT_ANSWER = 0x80, /* added to the type of a request */
    BT_REJECT = 0xFF
};

struct bt_server {
    struct bt_node *node;
    struct bt_ring rx, tx;
    struct bt_receiver receiver;
    struct bt_upload upload;
    bool has_sequence; /* a setpoint was taken since reset or IDENTIFY */
    uint32_t last_sequence;
    uint32_t dropped_before;
    uint8_t event_sequence;
    uint8_t reply[BT_MAX_REPLY];
    uint8_t rx_data[BT_RX_BYTES];
    uint8_t tx_data[BT_TX_BYTES];
};

/* Stands the server before a node, and boots. */
void bt_server_init(struct bt_server *server, struct bt_node *node);

/* Main loop: deal with what has come, and send what is due. */
void bt_server_poll(struct bt_server *server);

/* Whether a setpoint of this sequence is newer than the last one taken. */
bool bt_server_is_newer(const struct bt_server *server, uint32_t sequence);

#ifdef __cplusplus
}
#endif

#endif
