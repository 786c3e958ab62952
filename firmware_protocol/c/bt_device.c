/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_device.h"

#include <string.h>

#include "bt_relations.h"
#include "bt_sync.h"

/* From this value of quick_stop_option on the drive stays in Quick stop active at standstill (CiA 402-2, 0x605A). */
#define QUICK_STOP_HOLDS 5

#define STANDSTILL 0.01f /* of the rated speed */
#define USUAL_MODES (BT_MODE_BIT(BT_MODE_OF_OPERATION_VELOCITY) | BT_MODE_BIT(BT_MODE_OF_OPERATION_TORQUE))

uint8_t bt_error_register(uint16_t code)
{
    if (code == 0)
        return 0;
    switch (code >> 12) {
    case 2:
        return 0x03;
    case 3:
        return 0x05;
    case 4:
        return 0x09;
    case 8:
        return code >> 8 == 0x81 || code >> 8 == 0x82 ? 0x11 : 0x01;
    case 15:
        return code >> 8 == 0xFF ? 0x81 : 0x01;
    default:
        return 0x01;
    }
}

/* The targets are zeroed together with the state that makes a fresh command necessary. */
static void enter(struct bt_device *device, enum bt_state state)
{
    BT_LOCK();
    device->state = (uint8_t)state;
    device->rests = false;
    if (state == BT_STATE_OPERATION_ENABLED)
        device->standstill = false;
    if (state == BT_STATE_FAULT)
        bt_device_zero_targets(device);
    BT_UNLOCK();
}

void bt_device_zero_targets(struct bt_device *device)
{
    device->variables.torque_command = 0.0f;
    device->variables.omega_m_command = 0.0f;
    device->variables.target_torque = 0;
    device->variables.target_velocity = 0;
}

/* Code 0 tells that the error is over; it is no error, and not kept among them (CiA 301, 7.5.2.4). */
static void report(struct bt_device *device, uint16_t code)
{
    unsigned k;
    BT_LOCK();
    device->variables.error_code = code;
    device->variables.error_register = bt_error_register(code);
    BT_UNLOCK();
    if (code != 0) {
        for (k = BT_HISTORY - 1u; k > 0; k--)
            device->history[k] = device->history[k - 1u];
        device->history[0] = code;
        if (device->history_count < BT_HISTORY)
            device->history_count++;
    }
    if (device->emergency)
        device->emergency(device->emergency_context, code, bt_error_register(code));
}

static void quick_stop(struct bt_device *device, bool may_hold)
{
    const int16_t option = device->variables.quick_stop_option;
    if (option == BT_QUICK_STOP_OPTION_DISABLE || device->variables.angle_known == BT_ANGLE_KNOWN_NO) {
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
        return;
    }
    BT_LOCK();
    device->quick_stop_holds = may_hold && option >= QUICK_STOP_HOLDS;
    device->state = BT_STATE_QUICK_STOP_ACTIVE;
    BT_UNLOCK();
}

void bt_device_init(struct bt_device *device, const struct bt_config *config)
{
    memset(device, 0, sizeof *device);
    device->config = *config;
    device->variables.tick = config->first_tick;
    bt_device_reset(device);
}

/* The table's default, or the first mode that there is. */
static int8_t first_mode(const struct bt_variables *variables)
{
    const int8_t modes[] = { (int8_t)bt_entries[BT_ID_mode_of_operation].initial.i, BT_MODE_OF_OPERATION_VELOCITY,
                             BT_MODE_OF_OPERATION_TORQUE };
    unsigned k;
    for (k = 0; k < sizeof modes; k++) {
        if (variables->supported_modes & BT_MODE_BIT(modes[k]))
            return modes[k];
    }
    return BT_MODE_OF_OPERATION_VOLTAGE;
}

/* What the firmware says of the drive takes the place of the table's, and no default is beyond its ranges. */
static void identify(struct bt_device *device)
{
    const struct bt_config *config = &device->config;
    struct bt_variables *variables = &device->variables;
    BT_LOCK();
    if (config->vendor_id != 0)
        variables->vendor_id = config->vendor_id;
    if (config->product_code != 0)
        variables->product_code = config->product_code;
    if (config->revision_number != 0)
        variables->revision_number = config->revision_number;
    variables->serial_number = config->serial_number;
    variables->supported_modes = config->supported_modes != 0 ? config->supported_modes : USUAL_MODES;
    variables->mode_of_operation = first_mode(variables);
    variables->mode_of_operation_display = variables->mode_of_operation;
    variables->i_full_scale = config->i_full_scale;
    variables->u_dc_full_scale = config->u_dc_full_scale;
    variables->control_period = (float)config->tick_period_ns * 1e-9f;
    variables->pwm_period =
        config->pwm_period_ns != 0 ? (float)config->pwm_period_ns * 1e-9f : variables->control_period;
    bt_cut_to_relations(variables);
    BT_UNLOCK();
}

/* A trip that the main loop has not seen stays, and becomes a fault when it does. */
static void clear_trip(struct bt_device *device)
{
    if (device->trip_seen != 0)
        BT_STORE(&device->trip_code, 0);
    device->trip_seen = 0;
}

void bt_device_reset(struct bt_device *device)
{
    enter(device, BT_STATE_SWITCH_ON_DISABLED);
    clear_trip(device);
    BT_LOCK();
    device->controlword = 0;
    BT_UNLOCK();
    bt_set_defaults(&device->variables, device->config.node_id, 0, 0xFFFFu,
                    device->has_stored ? device->stored + 1 : NULL);
    identify(device);
    device->history_count = 0;
    bt_capture_abort(&device->capture);
    BT_LOCK();
    bt_currents_stop(&device->currents);
    BT_UNLOCK();
    bt_watchdog_configure(&device->watchdog, 0, device->config.tick_period_ns);
}

void bt_device_stop(struct bt_device *device)
{
    BT_LOCK();
    bt_device_zero_targets(device);
    BT_UNLOCK();
    if (bt_cia402_power_stage_on((enum bt_state)device->state))
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
}

/* No target outlives the link, and a quick stop without a host does not hold: there is none to end it. */
static void lose_link(struct bt_device *device)
{
    const int16_t action = device->variables.abort_connection_option;
    report(device, BT_ERROR_HEARTBEAT);
    BT_LOCK();
    bt_device_zero_targets(device);
    BT_UNLOCK();
    if (action == BT_ABORT_CONNECTION_OPTION_FAULT)
        enter(device, BT_STATE_FAULT);
    else if (!bt_cia402_power_stage_on((enum bt_state)device->state))
        return;
    else if (action == BT_ABORT_CONNECTION_OPTION_QUICK_STOP)
        quick_stop(device, false);
    else
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
}

static bool has_braked(struct bt_device *device)
{
    bool braked;
    BT_LOCK();
    braked = device->state == BT_STATE_QUICK_STOP_ACTIVE && device->standstill && !device->quick_stop_holds;
    BT_UNLOCK();
    return braked;
}

/* Its host is gone, and what it tried in the parameters goes as soon as nothing is controlled by them. */
static bool trial_is_over(const struct bt_device *device)
{
    return device->variables.parameter_trial == BT_PARAMETER_TRIAL_ON &&
           device->watchdog.state == BT_LINK_STATE_LOST &&
           !bt_cia402_power_stage_on((enum bt_state)device->state);
}

void bt_device_look_after(struct bt_device *device)
{
    const uint16_t trip = BT_LOAD(&device->trip_code);
    if (trip != device->trip_seen) {
        device->trip_seen = trip;
        if (device->state != BT_STATE_FAULT) {
            report(device, trip);
            enter(device, BT_STATE_FAULT);
        }
    }
    if (has_braked(device))
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
    if (bt_watchdog_lose(&device->watchdog)) {
        lose_link(device);
        bt_watchdog_settle(&device->watchdog);
    }
    if (trial_is_over(device)) {
        bt_set_parameters(&device->variables, device->has_stored ? device->stored + 1 : NULL);
        BT_LOCK();
        bt_cut_to_relations(&device->variables);
        device->variables.parameter_trial = BT_PARAMETER_TRIAL_OFF;
        BT_UNLOCK();
    }
}

/* Modes of the manufacturer, which are below 0, do without the angle. */
bool bt_device_has_angle(const struct bt_device *device, int32_t mode)
{
    return mode < 0 || device->variables.angle_known != BT_ANGLE_KNOWN_NO;
}

uint32_t bt_device_check_control(const struct bt_device *device, uint16_t controlword)
{
    const enum bt_state state = (enum bt_state)device->state;
    const enum bt_state after = bt_cia402_transition(state, controlword, device->controlword);
    if (after != BT_STATE_OPERATION_ENABLED || state == after)
        return BT_OK;
    if (!bt_watchdog_may_enable(&device->watchdog))
        return BT_ABORT_DEVICE_STATE;
    return bt_device_has_angle(device, device->variables.mode_of_operation) ? BT_OK : BT_ABORT_DEVICE_STATE;
}

void bt_device_control(struct bt_device *device, uint16_t controlword)
{
    const enum bt_state state = (enum bt_state)device->state;
    const enum bt_state after = bt_cia402_transition(state, controlword, device->controlword);
    const unsigned edges = controlword & ~(unsigned)device->controlword;
    BT_LOCK();
    device->controlword = controlword;
    BT_UNLOCK();
    if (edges & BT_CONTROL_FAULT_RESET && device->watchdog.state == BT_LINK_STATE_LOST) {
        bt_watchdog_rearm(&device->watchdog);
        if (state != BT_STATE_FAULT)
            report(device, 0);
    }
    if (after == state)
        return;
    if (state == BT_STATE_FAULT) {
        clear_trip(device);
        report(device, 0);
    }
    if (after == BT_STATE_QUICK_STOP_ACTIVE)
        quick_stop(device, true);
    else
        enter(device, after);
}

uint64_t bt_device_ticks(const struct bt_device *device)
{
    uint64_t ticks;
    BT_LOCK();
    ticks = (uint64_t)device->tick_wraps << 32 | device->variables.tick;
    BT_UNLOCK();
    return ticks;
}

void bt_device_count(uint32_t *counter, uint32_t more)
{
    BT_LOCK();
    *counter += more;
    BT_UNLOCK();
}

/* ---- from anywhere -------------------------------------------------------------------------------------- */

void bt_device_trip(struct bt_device *device, uint16_t code)
{
    if (code != 0 && bt_set_once(&device->trip_code, code))
        BT_STORE(&device->trip_edge, true);
}

/* ---- in the control interrupt --------------------------------------------------------------------------- */

/* A link that was lost counts from the tick in which it was, whether the main loop has seen it or not. */
static bool is_lost(const struct bt_device *device)
{
    return device->watchdog.expired;
}

bool bt_device_may_switch(const struct bt_device *device)
{
    if (!bt_cia402_power_stage_on((enum bt_state)device->state) || BT_LOAD(&device->trip_code) != 0)
        return false;
    if (bt_device_is_quick_stopping(device))
        return !device->standstill || (device->quick_stop_holds && !is_lost(device));
    return !is_lost(device);
}

bool bt_device_is_quick_stopping(const struct bt_device *device)
{
    const struct bt_variables *variables = &device->variables;
    if (!is_lost(device))
        return device->state == BT_STATE_QUICK_STOP_ACTIVE;
    return bt_cia402_power_stage_on((enum bt_state)device->state) &&
           variables->abort_connection_option == BT_ABORT_CONNECTION_OPTION_QUICK_STOP &&
           variables->quick_stop_option != BT_QUICK_STOP_OPTION_DISABLE;
}

void bt_device_standstill(struct bt_device *device)
{
    if (bt_device_is_quick_stopping(device))
        device->standstill = true;
}

bool bt_device_is_halted(const struct bt_device *device)
{
    return device->state == BT_STATE_OPERATION_ENABLED && device->controlword & BT_CONTROL_HALT;
}

static bool follows_setpoints(const struct bt_device *device)
{
    return device->state == BT_STATE_OPERATION_ENABLED && !bt_device_is_halted(device) && !is_lost(device);
}

float bt_device_torque_setpoint(const struct bt_device *device)
{
    return follows_setpoints(device) ? device->variables.torque_command : 0.0f;
}

float bt_device_omega_m_setpoint(const struct bt_device *device)
{
    return follows_setpoints(device) ? device->variables.omega_m_command : 0.0f;
}

void bt_device_take_currents(struct bt_device *device, const float reading[3])
{
    bt_currents_take(&device->currents, &device->variables, reading,
                     bt_cia402_power_stage_on((enum bt_state)device->state));
}

static float magnitude(float value)
{
    return value < 0.0f ? -value : value;
}

/* A halt without speed control makes no torque, and has come to its end with that. */
void bt_device_tick(struct bt_device *device)
{
    const struct bt_variables *variables = &device->variables;
    device->rests = bt_device_is_halted(device) &&
                    (variables->mode_of_operation_display != BT_MODE_OF_OPERATION_VELOCITY ||
                     magnitude(variables->omega_m) <= STANDSTILL * variables->omega_m_N);
}

/* Of a halt or a quick stop that holds; other targets are the host's to judge. */
static bool target_is_reached(const struct bt_device *device)
{
    if (device->state == BT_STATE_QUICK_STOP_ACTIVE)
        return device->quick_stop_holds && device->standstill;
    return device->rests && bt_device_is_halted(device);
}

uint16_t bt_device_statusword(const struct bt_device *device)
{
    const struct bt_variables *variables = &device->variables;
    const enum bt_state state = (enum bt_state)device->state;
    unsigned flags = BT_STATUS_REMOTE;
    if (variables->u_dc > variables->u_dc_min)
        flags |= BT_STATUS_VOLTAGE_ENABLED;
    if (device->watchdog.state == BT_LINK_STATE_LOST)
        flags |= BT_STATUS_WARNING;
    if (target_is_reached(device))
        flags |= BT_STATUS_TARGET_REACHED;
    if (bt_cia402_power_stage_on(state) && variables->torque_limit > 0.0f &&
        magnitude(variables->torque_reference) >= variables->torque_limit)
        flags |= BT_STATUS_INTERNAL_LIMIT;
    return bt_cia402_statusword(state, (uint16_t)flags);
}
