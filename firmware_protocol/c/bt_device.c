#include "bt_device.h"

#include "bt_bytes.h"

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

/* Take a state; setpoints do not outlive the power stage. The state goes first: the interrupt acts on it. */
static void enter(struct bt_device *device, enum bt_state state)
{
    device->state = (uint8_t)state;
    BT_BARRIER();
    if (state != BT_STATE_OPERATION_ENABLED) {
        device->variables.torque_command = 0.0f;
        device->variables.omega_m_command = 0.0f;
        device->variables.target_torque = 0;
        device->variables.target_velocity = 0;
    }
}

static void report(struct bt_device *device, uint16_t code)
{
    unsigned k;
    device->variables.error_code = code;
    device->variables.error_register = bt_error_register(code);
    for (k = BT_HISTORY - 1u; k > 0; k--)
        device->history[k] = device->history[k - 1u];
    device->history[0] = code;
    if (device->history_count < BT_HISTORY)
        device->history_count++;
    if (device->emergency)
        device->emergency(device->emergency_context, code, bt_error_register(code));
}

static void quick_stop(struct bt_device *device)
{
    if (device->variables.quick_stop_option == BT_QUICK_STOP_OPTION_DISABLE) {
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
        return;
    }
    device->standstill = false;
    BT_BARRIER();
    device->state = BT_STATE_QUICK_STOP_ACTIVE;
}

void bt_device_init(struct bt_device *device, const struct bt_config *config)
{
    memset(device, 0, sizeof *device);
    device->config = *config;
    bt_device_reset(device);
}

void bt_device_reset(struct bt_device *device)
{
    struct bt_variables *variables = &device->variables;
    uint32_t id, place = 0;
    enter(device, BT_STATE_SWITCH_ON_DISABLED);
    device->controlword = 0;
    bt_set_defaults(variables, device->config.node_id, 0, 0xFFFFu);
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        union bt_number number;
        if (bt_entries[id].role != BT_ROLE_PARAMETER)
            continue;
        number.u = device->stored[place++];
        if (device->has_stored)
            bt_store(variables, (enum bt_id)id, number);
    }
    variables->serial_number = device->config.serial_number;
    variables->i_full_scale = device->config.i_full_scale;
    variables->control_period = (float)device->config.tick_period_ns * 1e-9f;
    variables->mode_of_operation_display = variables->mode_of_operation;
    device->history_count = 0;
    bt_capture_abort(&device->capture);
    device->trip_code = 0;
    bt_watchdog_configure(&device->watchdog, 0, device->config.tick_period_ns);
}

void bt_device_stop(struct bt_device *device)
{
    if (bt_cia402_power_stage_on((enum bt_state)device->state))
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
}

static void lose_link(struct bt_device *device)
{
    report(device, BT_ERROR_HEARTBEAT);
    switch (device->variables.abort_connection_option) {
    case BT_ABORT_CONNECTION_OPTION_FAULT:
        enter(device, BT_STATE_FAULT);
        break;
    case BT_ABORT_CONNECTION_OPTION_DISABLE_VOLTAGE:
        bt_device_stop(device);
        break;
    case BT_ABORT_CONNECTION_OPTION_QUICK_STOP:
        if (device->state == BT_STATE_OPERATION_ENABLED)
            quick_stop(device);
        break;
    default:
        break;
    }
}

void bt_device_look_after(struct bt_device *device)
{
    const uint16_t trip = device->trip_code;
    if (trip != 0 && device->state != BT_STATE_FAULT) {
        report(device, trip);
        enter(device, BT_STATE_FAULT);
    }
    if (device->state == BT_STATE_QUICK_STOP_ACTIVE && device->standstill)
        enter(device, BT_STATE_SWITCH_ON_DISABLED);
    if (bt_watchdog_lose(&device->watchdog)) {
        lose_link(device);
        BT_BARRIER(); /* the state is what stops the motor from here on */
        device->watchdog.expired = false;
    }
}

uint32_t bt_device_check_control(const struct bt_device *device, uint16_t controlword)
{
    const enum bt_state state = (enum bt_state)device->state;
    const enum bt_state after = bt_cia402_transition(state, controlword, device->controlword);
    if (after == BT_STATE_OPERATION_ENABLED && state != after && !bt_watchdog_may_enable(&device->watchdog))
        return BT_ABORT_DEVICE_STATE;
    return BT_OK;
}

void bt_device_control(struct bt_device *device, uint16_t controlword)
{
    const enum bt_state state = (enum bt_state)device->state;
    const enum bt_state after = bt_cia402_transition(state, controlword, device->controlword);
    const unsigned edges = controlword & ~(unsigned)device->controlword;
    device->controlword = controlword;
    if (edges & BT_CONTROL_FAULT_RESET && device->watchdog.state == BT_LINK_STATE_LOST)
        bt_watchdog_rearm(&device->watchdog);
    if (after == state)
        return;
    if (state == BT_STATE_FAULT) {
        device->trip_code = 0;
        report(device, 0);
    }
    if (after == BT_STATE_QUICK_STOP_ACTIVE)
        quick_stop(device);
    else
        enter(device, after);
}

void bt_device_trip(struct bt_device *device, uint16_t code)
{
    if (device->trip_code == 0) {
        device->trip_code = code;
        device->trip_edge = true;
    }
}

/* A link that was lost counts from the tick in which it was, whether the main loop has seen it or not. */
bool bt_device_may_switch(const struct bt_device *device)
{
    const int16_t action = device->variables.abort_connection_option;
    if (!bt_cia402_power_stage_on((enum bt_state)device->state) || device->trip_code != 0)
        return false;
    return !device->watchdog.expired || (action != BT_ABORT_CONNECTION_OPTION_FAULT &&
                                         action != BT_ABORT_CONNECTION_OPTION_DISABLE_VOLTAGE);
}

bool bt_device_is_quick_stopping(const struct bt_device *device)
{
    return device->state == BT_STATE_QUICK_STOP_ACTIVE ||
           (device->watchdog.expired &&
            device->variables.abort_connection_option == BT_ABORT_CONNECTION_OPTION_QUICK_STOP);
}

uint16_t bt_device_statusword(const struct bt_device *device)
{
    const struct bt_variables *variables = &device->variables;
    const enum bt_state state = (enum bt_state)device->state;
    const float reference = variables->torque_reference < 0.0f ? -variables->torque_reference
                                                               : variables->torque_reference;
    unsigned flags = BT_STATUS_REMOTE;
    if (variables->u_dc > variables->u_dc_min)
        flags |= BT_STATUS_VOLTAGE_ENABLED;
    if (device->watchdog.state == BT_LINK_STATE_LOST)
        flags |= BT_STATUS_WARNING;
    if (bt_cia402_power_stage_on(state) && variables->torque_limit > 0.0f && reference >= variables->torque_limit)
        flags |= BT_STATUS_INTERNAL_LIMIT;
    return bt_cia402_statusword(state, (uint16_t)flags);
}
