/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* What becomes of a target (CiA 402-2): enabling, disabling, faults, halt and quick stop. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "check.h"
#include "host.h"

#define HALT 0x10Fu
#define TARGET_REACHED 0x400u
#define TARGETS 4u

static struct bt_drive drive;

static const enum bt_id targets[TARGETS] = { BT_ID_target_torque, BT_ID_target_velocity, BT_ID_torque_command,
                                             BT_ID_omega_m_command };

static void write_targets(void)
{
    assert(host_write(&drive, BT_ID_target_torque, 100) == BT_OK);
    assert(host_write(&drive, BT_ID_target_velocity, 20000) == BT_OK);
}

static bool are_kept(void)
{
    const float torque = 0.1f * bt_variables(&drive)->T_N, seen = bt_variables(&drive)->torque_command;
    return host_read(&drive, BT_ID_target_torque) == 100 && host_read(&drive, BT_ID_target_velocity) == 20000 &&
           seen > 0.999f * torque && seen < 1.001f * torque &&
           host_read(&drive, BT_ID_omega_m_command) == bt_word_of(20.0f);
}

static bool are_zero(void)
{
    unsigned k;
    for (k = 0; k < TARGETS; k++) {
        if (host_read(&drive, targets[k]) != 0)
            return false;
    }
    return true;
}

static void control(uint32_t word)
{
    assert(host_write(&drive, BT_ID_controlword, word) == BT_OK);
}

static uint32_t state(void)
{
    return host_read(&drive, BT_ID_statusword) & 0x6Fu;
}

static void enabled_with_targets(void)
{
    check_power_up(&drive);
    write_targets();
    assert(bt_torque_setpoint(&drive) == 0.0f && bt_omega_m_setpoint(&drive) == 0.0f);
    host_enable(&drive);
}

static void check_kept(void)
{
    static const uint16_t disabling[] = { 0x06, 0x07, 0x00, 0x02 };
    unsigned k;
    for (k = 0; k < 4; k++) {
        enabled_with_targets();
        assert(are_kept() && bt_omega_m_setpoint(&drive) == 20.0f && bt_torque_setpoint(&drive) > 0.0f);
        control(disabling[k]);
        bt_standstill(&drive);
        bt_poll(&drive);
        assert(state() != 0x27u && are_kept());
        assert(bt_omega_m_setpoint(&drive) == 0.0f && bt_torque_setpoint(&drive) == 0.0f);
        host_enable(&drive);
        assert(are_kept() && bt_omega_m_setpoint(&drive) == 20.0f);
    }
    host_nmt(&drive, BT_NMT_RESET_COMMUNICATION);
    assert(are_kept());
    assert(host_write(&drive, BT_ID_mode_of_operation, 4) == BT_OK && are_kept()); /* no change */
}

static void lose_link(uint32_t action)
{
    unsigned k;
    enabled_with_targets();
    control(0);
    assert(host_write(&drive, BT_ID_abort_connection_option, action) == BT_OK);
    assert(host_write(&drive, BT_ID_host_heartbeat, (uint32_t)127 << 16 | 5) == BT_OK);
    host_heartbeat(&drive);
    host_enable(&drive);
    for (k = 0; k < 5; k++)
        bt_tick(&drive);
}

static void check_zeroed(void)
{
    enabled_with_targets();
    bt_trip(&drive, BT_ERROR_OVERCURRENT);
    bt_poll(&drive);
    assert(are_zero());

    enabled_with_targets();
    assert(host_write(&drive, BT_ID_mode_of_operation, 3) == BT_OK && are_zero());

    enabled_with_targets();
    host_nmt(&drive, BT_NMT_RESET_NODE);
    assert(are_zero());

    enabled_with_targets();
    host_nmt(&drive, BT_NMT_STOP); /* to CiA 402 a connection lost */
    host_nmt(&drive, BT_NMT_START);
    assert(are_zero());

    lose_link(BT_ABORT_CONNECTION_OPTION_FAULT);
    assert(bt_torque_setpoint(&drive) == 0.0f); /* before the main loop knows */
    assert(are_zero());
    lose_link(BT_ABORT_CONNECTION_OPTION_DISABLE_VOLTAGE);
    assert(are_zero());
    lose_link(BT_ABORT_CONNECTION_OPTION_QUICK_STOP);
    assert(are_zero());
}

/* State and "target reached" after the next tick. */
static uint32_t status(void)
{
    bt_tick(&drive);
    return host_read(&drive, BT_ID_statusword) & 0x46Fu;
}

static void check_halt(void)
{
    struct bt_variables *v = bt_variables(&drive);
    enabled_with_targets();
    v->omega_m = 20.0f;
    control(HALT);
    assert(bt_is_halted(&drive) && bt_may_switch(&drive) && are_kept());
    assert(bt_torque_setpoint(&drive) == 0.0f && bt_omega_m_setpoint(&drive) == 0.0f);
    assert(status() == 0x427u); /* torque mode: the reference is zero from then on */
    assert(host_write(&drive, BT_ID_mode_of_operation, 3) == BT_OK);
    write_targets();
    assert(status() == 0x027u);
    v->omega_m = -0.011f * v->omega_m_N;
    assert(status() == 0x027u);
    v->omega_m = -0.009f * v->omega_m_N;
    assert(status() == 0x427u);
    control(0x0F);
    assert(!(host_read(&drive, BT_ID_statusword) & TARGET_REACHED));
    assert(!bt_is_halted(&drive) && bt_omega_m_setpoint(&drive) == 20.0f && status() == 0x027u);
    control(0x06);
    control(HALT); /* enabled, and halted */
    assert(!(host_read(&drive, BT_ID_statusword) & TARGET_REACHED) && bt_is_halted(&drive) && status() == 0x427u);
    control(0x102); /* a quick stop of a halted axis has not come to its end */
    assert(bt_is_quick_stopping(&drive) && bt_may_switch(&drive) && status() == 0x007u);
    bt_standstill(&drive);
    assert(status() == 0x040u && !bt_is_halted(&drive));
}

/* The power stage is off from the tick in which the shaft stands, though the main loop hangs. */
static void check_quick_stop(void)
{
    enabled_with_targets();
    control(0x02);
    assert(bt_is_quick_stopping(&drive) && bt_may_switch(&drive) && bt_omega_m_setpoint(&drive) == 0.0f);
    bt_standstill(&drive);
    assert(!bt_may_switch(&drive));
    bt_tick(&drive);
    assert(!bt_may_switch(&drive));
    assert(state() == 0x40u && are_kept());
    host_enable(&drive);
    bt_standstill(&drive); /* of nothing */
    control(0x02);
    assert(bt_is_quick_stopping(&drive) && bt_may_switch(&drive));

    enabled_with_targets();
    bt_variables(&drive)->quick_stop_option = 6; /* holds zero speed */
    control(0x02);
    bt_poll(&drive);
    assert(!(host_read(&drive, BT_ID_statusword) & TARGET_REACHED));
    bt_standstill(&drive);
    bt_poll(&drive);
    assert(bt_may_switch(&drive) && bt_is_quick_stopping(&drive));
    assert((host_read(&drive, BT_ID_statusword) & 0x46Fu) == 0x407u);
    control(0x00);
    assert(state() == 0x40u);

    lose_link(BT_ABORT_CONNECTION_OPTION_QUICK_STOP);
    bt_variables(&drive)->quick_stop_option = 6; /* which counts for a host's quick stop only */
    bt_standstill(&drive);
    assert(!bt_may_switch(&drive));
    bt_poll(&drive);
    bt_poll(&drive);
    assert(state() == 0x40u);

    lose_link(BT_ABORT_CONNECTION_OPTION_QUICK_STOP);
    bt_variables(&drive)->quick_stop_option = BT_QUICK_STOP_OPTION_DISABLE;
    assert(!bt_may_switch(&drive));
    assert(state() == 0x40u);
}

void check_targets(void)
{
    check_kept();
    check_zeroed();
    check_halt();
    check_quick_stop();
    printf("targets: kept, zeroed, halted; quick stops that end and that hold\n");
}
