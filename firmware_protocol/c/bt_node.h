/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The drive as its lines share it: one device, one NMT state (CiA 301, 7.3.2), one stream. */
#ifndef BT_NODE_H
#define BT_NODE_H

#include "bt_device.h"
#include "bt_stream.h"

#ifdef __cplusplus
extern "C" {
#endif

enum bt_nmt_state {
    BT_NMT_BOOT_UP = 0,
    BT_NMT_STOPPED = 4,
    BT_NMT_OPERATIONAL = 5,
    BT_NMT_PRE_OPERATIONAL = 127
};

enum bt_nmt_command {
    BT_NMT_START = 1,
    BT_NMT_STOP = 2,
    BT_NMT_ENTER_PRE_OPERATIONAL = 128,
    BT_NMT_RESET_NODE = 129,
    BT_NMT_RESET_COMMUNICATION = 130
};

/* What a line is told. */
struct bt_line {
    void *context;
    void (*boot)(void *context);                      /* powered up or reset: announce it, forget the host's settings */
    void (*confirm)(void *context, uint8_t state);    /* the host has commanded a state */
    void (*heartbeat)(void *context, uint8_t state);  /* its period is over */
    void (*emergency)(void *context, uint16_t code, uint8_t error_register);
};

#define BT_LINES 2u

struct bt_node {
    struct bt_device device;
    struct bt_stream stream;
    const void *stream_owner; /* the line that has configured the stream, or NULL */
    volatile uint8_t nmt_state; /* enum bt_nmt_state */
    uint32_t heartbeat_ticks; /* of its period */
    uint64_t heartbeat_next;  /* ticks since power-up */
    unsigned line_count;
    struct bt_line lines[BT_LINES];
};

void bt_node_init(struct bt_node *node, const struct bt_config *config);

/* Puts a line into service, and boots it. */
void bt_node_add(struct bt_node *node, const struct bt_line *line);

/* Takes a command of network management; a number that is none is ignored. */
void bt_node_command(struct bt_node *node, uint8_t command);

/* A heartbeat was heard; that of the host feeds the supervision. */
void bt_node_take_heartbeat(struct bt_node *node, uint8_t from);

/* Takes both setpoints or neither; if they are taken they feed the supervision. */
bool bt_node_take_setpoint(struct bt_node *node, const uint8_t torque[4], const uint8_t omega_m[4]);

/* Main loop: states that the control interrupt has brought about, and heartbeats that are due. */
void bt_node_poll(struct bt_node *node);

/* Control interrupt: after control has written its signals. Counts the tick, watches the link, captures, streams. */
void bt_node_tick(struct bt_node *node);

#ifdef __cplusplus
}
#endif

#endif
