/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* States, trips and the watchdog: what stops the motor. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "check.h"
#include "host.h"

#define SUPERVISION ((uint32_t)127 << 16 | 500)

static struct bt_drive drive;

static void run(unsigned ticks)
{
    while (ticks-- > 0)
        bt_tick(&drive);
}

static void supervised(uint32_t action)
{
    check_power_up(&drive);
    assert(host_write(&drive, BT_ID_abort_connection_option, action) == BT_OK);
    assert(host_write(&drive, BT_ID_host_heartbeat, SUPERVISION) == BT_OK);
    assert(host_read(&drive, BT_ID_link_state) == BT_LINK_STATE_WAITING);
    host_nmt(&drive, BT_NMT_START);
    host_write(&drive, BT_ID_controlword, 6);
    host_write(&drive, BT_ID_controlword, 7);
    assert(host_write(&drive, BT_ID_controlword, 15) == BT_ABORT_DEVICE_STATE);
    host_heartbeat(&drive);
    assert(host_write(&drive, BT_ID_controlword, 15) == BT_OK);
    assert(bt_may_switch(&drive));
}

/* Silence switches off in the tick in which it is too long, though the main loop hangs. */
static void check_silence(void)
{
    supervised(BT_ABORT_CONNECTION_OPTION_FAULT);
    run(496); /* so many that the torque has ended after 500 */
    assert(bt_may_switch(&drive));
    run(1);
    assert(!bt_may_switch(&drive));
    host_heartbeat(&drive); /* too late */
    assert(!bt_may_switch(&drive));
    assert((host_read(&drive, BT_ID_statusword) & 0x4Fu) == 0x08u);
    assert(host_read(&drive, BT_ID_link_state) == BT_LINK_STATE_LOST);
    assert(host_read(&drive, BT_ID_link_losses) == 1);
    assert(host_read(&drive, BT_ID_error_1) == BT_ERROR_HEARTBEAT);
    host_heartbeat(&drive);
    assert(host_read(&drive, BT_ID_link_state) == BT_LINK_STATE_LOST);
    assert(host_write(&drive, BT_ID_controlword, 0) == BT_OK);
    assert(host_write(&drive, BT_ID_controlword, 0x80) == BT_OK);
    assert(host_read(&drive, BT_ID_link_state) == BT_LINK_STATE_WAITING);
}

/* Nor does a message that is handled before the loss is: as if the interrupt came in the midst of bt_poll. */
static void check_silence_in_a_poll(void)
{
    uint8_t message[9] = { BT_WRITE, 1 }, frame[64];
    uint8_t data[128];
    struct bt_ring line;
    size_t n;
    supervised(BT_ABORT_CONNECTION_OPTION_FAULT);
    bt_put_u16(message + 2, bt_entries[BT_ID_host_heartbeat].index);
    message[4] = bt_entries[BT_ID_host_heartbeat].sub;
    bt_put_u32(message + 5, SUPERVISION);
    bt_ring_init(&line, data, sizeof data);
    assert(bt_frame_send(&line, message, sizeof message, 0));
    n = bt_ring_get(&line, frame, sizeof frame);
    run(500);
    bt_receive(&drive, frame, n);
    bt_server_poll(&drive.serial);
    while (host_hear(&drive, data, sizeof data) > 0) {
    }
    assert(!bt_may_switch(&drive));
    assert((host_read(&drive, BT_ID_statusword) & 0x4Fu) == 0x08u);
}

static void check_actions(void)
{
    supervised(BT_ABORT_CONNECTION_OPTION_DISABLE_VOLTAGE);
    run(500);
    assert(!bt_may_switch(&drive));
    assert((host_read(&drive, BT_ID_statusword) & 0x6Fu) != 0x27u);

    check_power_up(&drive);
    assert(host_write(&drive, BT_ID_abort_connection_option, 0) == BT_ABORT_VALUE); /* no reaction */
    assert(host_write(&drive, BT_ID_host_heartbeat, (uint32_t)127 << 16 | 2001u) == BT_ABORT_VALUE_HIGH);
    assert(host_write(&drive, BT_ID_host_heartbeat, (uint32_t)127 << 16 | 2000u) == BT_OK);

    supervised(BT_ABORT_CONNECTION_OPTION_QUICK_STOP);
    run(500);
    assert(bt_may_switch(&drive) && bt_is_quick_stopping(&drive));
    bt_poll(&drive);
    assert(bt_may_switch(&drive) && bt_is_quick_stopping(&drive));
    bt_standstill(&drive);
    assert(!bt_may_switch(&drive));
    bt_poll(&drive);
    assert(!bt_may_switch(&drive) && !bt_is_quick_stopping(&drive));
}

/* Only the host's heartbeat and a setpoint that is taken keep it running. */
static void check_feeds(void)
{
    uint8_t setpoint[13] = { BT_SETPOINT, 5 };
    unsigned k;
    supervised(BT_ABORT_CONNECTION_OPTION_FAULT);
    for (k = 0; k < 4; k++) {
        run(300);
        setpoint[1] = (uint8_t)(5 + k);
        host_send(&drive, setpoint, sizeof setpoint);
        assert(bt_may_switch(&drive));
    }
    for (k = 0; k < 2; k++) {
        const uint8_t stranger[3] = { BT_HOST_HEARTBEAT, 126, 5 };
        run(250);
        host_send(&drive, setpoint, sizeof setpoint); /* a replay */
        host_send(&drive, stranger, sizeof stranger);
        (void)host_read(&drive, BT_ID_R_s);
    }
    assert(!bt_may_switch(&drive));
}

static void check_trips(void)
{
    uint8_t event[BT_MAX_REPLY];
    check_power_up(&drive);
    host_enable(&drive);
    host_write(&drive, BT_ID_torque_command, bt_word_of(0.5f));
    bt_trip(&drive, 0);
    assert(bt_may_switch(&drive));
    bt_trip(&drive, BT_ERROR_OVERCURRENT);
    bt_trip(&drive, BT_ERROR_OVERSPEED);
    assert(!bt_may_switch(&drive));
    while (host_hear(&drive, event, sizeof event) > 0) {
    }
    bt_poll(&drive);
    assert(host_hear(&drive, event, sizeof event) == 14 && event[0] == BT_EVENT && event[1] == 0);
    assert(bt_get_u16(event + 6) == BT_ERROR_OVERCURRENT && event[8] == 0x03);
    assert(host_read(&drive, BT_ID_torque_command) == 0);
    host_write(&drive, BT_ID_controlword, 0);
    host_write(&drive, BT_ID_controlword, 0x80);
    assert((host_read(&drive, BT_ID_statusword) & 0x4Fu) == 0x40u);
    assert(host_read(&drive, BT_ID_error_1) == BT_ERROR_OVERCURRENT && host_read(&drive, BT_ID_error_history_count) == 1);
    assert(host_hear(&drive, event, sizeof event) == 0 && host_read(&drive, BT_ID_error_code) == 0);
    host_enable(&drive);
    host_nmt(&drive, BT_NMT_STOP);
    assert(!bt_may_switch(&drive));
}

/* A trip of a break interrupt that comes between the steps of the main loop is there after them. */
static void check_trips_between(void)
{
    struct bt_device *device = &drive.node.device;
    supervised(BT_ABORT_CONNECTION_OPTION_FAULT);
    run(500);
    assert((host_read(&drive, BT_ID_statusword) & 0x4Fu) == 0x08u); /* a fault without a trip */
    bt_trip(&drive, BT_ERROR_OVERCURRENT);
    bt_device_control(device, 0x80); /* before the main loop has looked */
    assert(!bt_may_switch(&drive));
    bt_poll(&drive);
    assert(device->state == BT_STATE_FAULT && device->history[0] == BT_ERROR_OVERCURRENT);

    check_power_up(&drive);
    bt_trip(&drive, BT_ERROR_OVERSPEED);
    bt_device_reset(device);
    bt_poll(&drive);
    assert(device->state == BT_STATE_FAULT && device->history[0] == BT_ERROR_OVERSPEED);
    bt_device_control(device, 0);
    bt_device_control(device, 0x80);
    bt_poll(&drive);
    assert(device->state == BT_STATE_SWITCH_ON_DISABLED); /* what was seen is cleared */
}

/* Without the rotor's angle no mode of the standard is enabled, and none is taken then; a quick stop switches off. */
static void check_angle(void)
{
    struct bt_device *device = &drive.node.device;
    check_power_up(&drive);
    device->variables.angle_known = BT_ANGLE_KNOWN_NO;
    assert(host_read(&drive, BT_ID_angle_known) == BT_ANGLE_KNOWN_NO);
    host_nmt(&drive, BT_NMT_START);
    host_write(&drive, BT_ID_controlword, 6);
    host_write(&drive, BT_ID_controlword, 7);
    assert(host_write(&drive, BT_ID_controlword, 15) == BT_ABORT_DEVICE_STATE);
    assert(!bt_may_switch(&drive));
    device->variables.angle_known = BT_ANGLE_KNOWN_YES;
    assert(host_write(&drive, BT_ID_controlword, 15) == BT_OK);
    device->variables.angle_known = BT_ANGLE_KNOWN_NO; /* as in a mode of the manufacturer */
    assert(host_write(&drive, BT_ID_mode_of_operation, BT_MODE_OF_OPERATION_VELOCITY) == BT_ABORT_DEVICE_STATE);
    host_write(&drive, BT_ID_controlword, 2);
    assert(device->state == BT_STATE_SWITCH_ON_DISABLED && !bt_may_switch(&drive));
}

void check_control(void)
{
    check_angle();
    check_silence();
    check_silence_in_a_poll();
    check_actions();
    check_feeds();
    check_trips();
    check_trips_between();
    printf("control: silence, its actions, what feeds, trips\n");
}
