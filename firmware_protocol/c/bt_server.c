/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_server.h"

#include "bt_bytes.h"

#define REJECT_UNKNOWN_TYPE 1u
#define REJECT_WRONG_LENGTH 2u
#define REJECT_BUSY 3u
#define BATCHES_PER_POLL 8u
#define IDENTITY_HEAD 39u
#define READ_REPLY_HEAD 9u

static uint32_t tick(const struct bt_server *server)
{
    return (uint32_t)bt_device_ticks(&server->node->device);
}

static struct bt_variables *variables(const struct bt_server *server)
{
    return &server->node->device.variables;
}

static void send(struct bt_server *server, size_t n)
{
    (void)bt_frame_send(&server->tx, server->reply, n, 0);
}

static bool send_batch(void *context, const uint8_t *payload, size_t n)
{
    struct bt_server *server = context;
    return bt_frame_send(&server->tx, payload, n, BT_TX_RESERVE);
}

/* Type, tag and status of an answer. */
static uint8_t *begin(struct bt_server *server, const uint8_t *request, uint32_t status)
{
    server->reply[0] = (uint8_t)(request[0] + BT_ANSWER);
    server->reply[1] = request[1];
    bt_put_u32(server->reply + 2, status);
    return server->reply;
}

static void reject(struct bt_server *server, const uint8_t *request, size_t n, uint8_t reason)
{
    server->reply[0] = BT_REJECT;
    server->reply[1] = n > 1 ? request[1] : 0;
    server->reply[2] = request[0];
    server->reply[3] = reason;
    send(server, 4);
}

/* ---- requests ------------------------------------------------------------------------------------------- */

static void identify(struct bt_server *server, const uint8_t *request)
{
    const struct bt_node *node = server->node;
    const char *name = bt_text(&node->device, BT_ID_device_name);
    const bool spoken = request[2] == BT_PROTOCOL_VERSION;
    uint8_t *reply = begin(server, request, spoken ? BT_OK : BT_ABORT_NOT_STORED);
    size_t length = strlen(name);
    if (spoken)
        server->has_sequence = false;
    if (length > 255u)
        length = 255u;
    if (length > BT_MAX_REPLY - IDENTITY_HEAD)
        length = BT_MAX_REPLY - IDENTITY_HEAD;
    reply[6] = BT_PROTOCOL_VERSION;
    reply[7] = node->device.config.node_id;
    reply[8] = node->nmt_state;
    reply[9] = 0;
    bt_put_u32(reply + 10, variables(server)->dictionary_hash);
    bt_put_u32(reply + 14, variables(server)->vendor_id);
    bt_put_u32(reply + 18, variables(server)->product_code);
    bt_put_u32(reply + 22, variables(server)->revision_number);
    bt_put_u32(reply + 26, variables(server)->serial_number);
    bt_put_u32(reply + 30, node->device.config.tick_period_ns);
    bt_put_u16(reply + 34, BT_MAX_REQUEST);
    bt_put_u16(reply + 36, BT_MAX_REPLY);
    reply[38] = (uint8_t)length;
    memcpy(reply + IDENTITY_HEAD, name, length);
    send(server, IDENTITY_HEAD + length);
}

static uint32_t read_object(const struct bt_server *server, const uint8_t *request, struct bt_value *value)
{
    memset(value, 0, sizeof *value);
    if (server->node->nmt_state == BT_NMT_STOPPED)
        return BT_ABORT_DEVICE_STATE;
    return bt_read(&server->node->device, bt_get_u16(request + 2), request[4], value);
}

static void read_request(struct bt_server *server, const uint8_t *request)
{
    struct bt_value value;
    uint32_t status = read_object(server, request, &value);
    uint8_t *reply;
    if (status == BT_OK && value.n > BT_MAX_REPLY - READ_REPLY_HEAD)
        status = BT_ABORT_OUT_OF_MEMORY;
    reply = begin(server, request, status);
    memcpy(reply + 6, request + 2, 3);
    if (status == BT_OK)
        bt_value_copy(&server->node->device, &value, 0, reply + READ_REPLY_HEAD, value.n);
    send(server, READ_REPLY_HEAD + (status == BT_OK ? value.n : 0));
}

static void write_request(struct bt_server *server, const uint8_t *request, size_t n)
{
    uint32_t status = BT_ABORT_DEVICE_STATE;
    uint8_t *reply;
    if (server->node->nmt_state != BT_NMT_STOPPED)
        status = bt_write(&server->node->device, bt_get_u16(request + 2), request[4], request + 5, n - 5u);
    reply = begin(server, request, status);
    memcpy(reply + 6, request + 2, 3);
    send(server, 9);
}

static void open_request(struct bt_server *server, const uint8_t *request)
{
    struct bt_value value;
    const uint32_t status = read_object(server, request, &value);
    uint8_t *reply = begin(server, request, status);
    memcpy(reply + 6, request + 2, 3);
    memset(reply + 9, 0, 11);
    if (status == BT_OK) {
        const uint32_t crc = bt_upload_open(&server->upload, &server->node->device, &value);
        reply[9] = server->upload.number;
        bt_put_u32(reply + 10, (uint32_t)value.n);
        bt_put_u16(reply + 14, BT_CHUNK_BYTES);
        bt_put_u32(reply + 16, crc);
    }
    send(server, 20);
}

static void chunks_request(struct bt_server *server, const uint8_t *request)
{
    const uint32_t status = bt_upload_ask(&server->upload, &server->node->device, request);
    if (status != BT_OK) {
        uint8_t *reply = begin(server, request, status);
        memcpy(reply + 6, request + 2, 5);
        send(server, 11);
    }
}

static void end_stream(struct bt_server *server)
{
    struct bt_stream *stream = &server->node->stream;
    if (server->node->stream_owner == server) {
        bt_stream_pause(stream, server->reply, send_batch, server);
        stream->configured = false;
        server->node->stream_owner = NULL;
    }
}

static void run_stream(struct bt_server *server)
{
    struct bt_node *node = server->node;
    if (node->stream_owner != server)
        return;
    if (node->nmt_state == BT_NMT_OPERATIONAL)
        bt_stream_resume(&node->stream, &node->device);
    else
        bt_stream_pause(&node->stream, server->reply, send_batch, server);
}

static void stream_request(struct bt_server *server, const uint8_t *request)
{
    struct bt_node *node = server->node;
    struct bt_stream *stream = &node->stream;
    struct bt_stream_layout layout;
    const bool stops = bt_get_u16(request + 2) == 0;
    uint32_t status = BT_OK, sent, dropped;
    uint8_t *reply;
    if (node->nmt_state == BT_NMT_STOPPED)
        status = BT_ABORT_DEVICE_STATE;
    else if (!stops)
        status = bt_stream_layout(request, &layout);
    if (status == BT_OK && !stops && node->stream_owner != NULL && node->stream_owner != server) {
        reject(server, request, 2, REJECT_BUSY);
        return;
    }
    if (status == BT_OK)
        end_stream(server);
    sent = stream->sent;
    dropped = stream->dropped;
    if (status == BT_OK && !stops) {
        bt_stream_begin(stream, &layout);
        node->stream_owner = server;
    }
    reply = begin(server, request, status);
    bt_put_u16(reply + 6, stream->schema);
    bt_put_u32(reply + 8, sent);
    bt_put_u32(reply + 12, dropped);
    send(server, 16);
    run_stream(server);
}

/* ---- messages that are not answered --------------------------------------------------------------------- */

bool bt_server_is_newer(const struct bt_server *server, uint32_t sequence)
{
    const uint32_t ahead = sequence - server->last_sequence;
    return !server->has_sequence || (ahead >= 1u && ahead <= 0x7FFFFFFFu);
}

static void setpoint(struct bt_server *server, const uint8_t *message)
{
    const uint32_t sequence = bt_get_u32(message + 1);
    if (server->node->nmt_state != BT_NMT_OPERATIONAL)
        return;
    if (bt_server_is_newer(server, sequence) && bt_node_take_setpoint(server->node, message + 5, message + 9)) {
        server->has_sequence = true;
        server->last_sequence = sequence;
    } else {
        bt_device_count(&variables(server)->rpdo_dropped, 1);
    }
}

/* Whether a message has the length that its type and fields give; all types known here. */
static bool has_its_length(const uint8_t *message, size_t n)
{
    switch (message[0]) {
    case BT_IDENTIFY:
        return n == 3;
    case BT_READ:
    case BT_OPEN:
        return n == 5;
    case BT_WRITE:
        return n >= 6;
    case BT_CHUNKS:
        return n == 9;
    case BT_STREAM:
        return n >= 7 && message[5] <= 1 && n == 7u + (message[5] ? 8u : 4u) * message[6];
    case BT_SETPOINT:
        return n == 13;
    case BT_HOST_HEARTBEAT:
        return n == 3;
    default:
        return n == 2;
    }
}

static bool is_known(uint8_t type)
{
    return (type >= BT_IDENTIFY && type <= BT_STREAM) || (type >= BT_SETPOINT && type <= BT_NMT);
}

static void handle(struct bt_server *server, const uint8_t *message, size_t n)
{
    const uint8_t type = message[0];
    if (!is_known(type) || !has_its_length(message, n)) {
        bt_device_count(&variables(server)->serial_dropped, 1);
        if (type >= BT_IDENTIFY && type <= BT_LAST_REQUEST)
            reject(server, message, n, is_known(type) ? REJECT_WRONG_LENGTH : REJECT_UNKNOWN_TYPE);
        return;
    }
    switch (type) {
    case BT_IDENTIFY:
        identify(server, message);
        break;
    case BT_READ:
        read_request(server, message);
        break;
    case BT_WRITE:
        write_request(server, message, n);
        break;
    case BT_OPEN:
        open_request(server, message);
        break;
    case BT_CHUNKS:
        chunks_request(server, message);
        break;
    case BT_STREAM:
        stream_request(server, message);
        break;
    case BT_SETPOINT:
        setpoint(server, message);
        break;
    case BT_HOST_HEARTBEAT:
        bt_node_take_heartbeat(server->node, message[1]);
        break;
    default:
        bt_node_command(server->node, message[1]);
        break;
    }
}

/* ---- what the node tells -------------------------------------------------------------------------------- */

static void heartbeat(void *context, uint8_t state)
{
    struct bt_server *server = context;
    server->reply[0] = BT_HEARTBEAT;
    server->reply[1] = state;
    bt_put_u32(server->reply + 2, tick(server));
    send(server, 6);
}

static void boot(void *context)
{
    struct bt_server *server = context;
    end_stream(server);
    server->has_sequence = false;
    bt_upload_end(&server->upload);
    heartbeat(server, BT_NMT_BOOT_UP);
}

static void confirm(void *context, uint8_t state)
{
    run_stream(context);
    heartbeat(context, state);
}

static void emergency(void *context, uint16_t code, uint8_t error_register)
{
    struct bt_server *server = context;
    uint8_t event[14] = { BT_EVENT }; /* an answer may be half made in `reply` */
    event[1] = server->event_sequence++;
    bt_put_u32(event + 2, tick(server));
    bt_put_u16(event + 6, code);
    event[8] = error_register;
    (void)bt_frame_send(&server->tx, event, sizeof event, 0);
}

void bt_server_init(struct bt_server *server, struct bt_node *node)
{
    struct bt_line line = { server, boot, confirm, heartbeat, emergency };
    memset(server, 0, sizeof *server);
    server->node = node;
    bt_ring_init(&server->rx, server->rx_data, sizeof server->rx_data);
    bt_ring_init(&server->tx, server->tx_data, sizeof server->tx_data);
    bt_receiver_init(&server->receiver, BT_MAX_REQUEST);
    bt_node_add(node, &line);
}

void bt_server_poll(struct bt_server *server)
{
    uint32_t left = bt_ring_waiting(&server->rx);
    uint8_t byte;
    while (left-- > 0 && bt_ring_get(&server->rx, &byte, 1) == 1) {
        const size_t n = bt_receiver_take(&server->receiver, byte);
        const uint32_t dropped = bt_receiver_dropped(&server->receiver);
        if (dropped != server->dropped_before)
            bt_device_count(&variables(server)->serial_dropped, dropped - server->dropped_before);
        server->dropped_before = dropped;
        if (n > 0) {
            bt_device_look_after(&server->node->device); /* no message undoes what the interrupt has found */
            handle(server, server->receiver.data, n);
        }
    }
    bt_upload_send(&server->upload, &server->node->device, &server->tx, server->reply);
    if (server->node->stream_owner == server)
        bt_stream_transmit(&server->node->stream, BATCHES_PER_POLL, server->reply, send_batch, server);
}
