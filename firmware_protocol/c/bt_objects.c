/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Access to the dictionary: what is more than a variable, what may not be written now, what a write does. */
#include "bt_bytes.h"
#include "bt_device.h"
#include "bt_pdo.h"
#include "bt_relations.h"
#include "bt_sync.h"

#define SIGNATURE_SAVE 0x65766173u
#define SIGNATURE_LOAD 0x64616F6Cu
#define ABORT_HARDWARE 0x06060000u

/* To the nearest integer, within limits that a float holds exactly; no number is 0. */
static int32_t rounded(float value, float low, float high)
{
    int32_t whole;
    if (value != value)
        return 0;
    value = value < low ? low : value > high ? high : value;
    whole = (int32_t)value;
    if (value - (float)whole >= 0.5f)
        return whole + 1;
    return value - (float)whole <= -0.5f ? whole - 1 : whole;
}

static int32_t in_16_bits(float value)
{
    return rounded(value, -32768.0f, 32767.0f);
}

static int32_t in_32_bits(float value)
{
    return rounded(value, -2147483648.0f, 2147483520.0f);
}

uint32_t bt_number(const struct bt_device *device, enum bt_id id, union bt_number *number)
{
    const struct bt_variables *variables = &device->variables;
    number->u = 0;
    switch (id) {
    case BT_ID_statusword:
        number->u = bt_device_statusword(device);
        break;
    case BT_ID_link_state:
        number->u = device->watchdog.state;
        break;
    case BT_ID_link_losses:
        number->u = device->watchdog.losses;
        break;
    case BT_ID_error_history_count:
        number->u = device->history_count;
        break;
    case BT_ID_store_all:
    case BT_ID_restore_all:
        number->u = 1;
        break;
    case BT_ID_capture_state:
        number->u = device->capture.state;
        break;
    case BT_ID_offset_calibration_state:
        number->u = device->currents.state;
        break;
    case BT_ID_capture_rows_done:
        number->u = device->capture.rows_done;
        break;
    case BT_ID_capture_trigger_tick:
        number->u = device->capture.trigger_tick;
        break;
    case BT_ID_capture_sequence:
        number->u = device->capture.sequence;
        break;
    case BT_ID_motor_rated_torque:
        number->i = in_32_bits(variables->T_N * 1e3f);
        break;
    case BT_ID_torque_actual:
        number->i = in_16_bits(variables->torque / variables->T_N * 1e3f);
        break;
    case BT_ID_current_actual:
        number->i = in_16_bits(variables->i_q * 0.70710678f / (float)variables->motor_rated_current * 1e6f);
        break;
    case BT_ID_velocity_actual:
        number->i = in_32_bits(variables->omega_m * 1e3f);
        break;
    case BT_ID_dc_link_voltage:
        number->i = variables->u_dc > 0.0f ? in_32_bits(variables->u_dc * 1e3f) : 0;
        break;
    default:
        if (id >= BT_ID_error_1 && id <= BT_ID_error_8) {
            if ((unsigned)(id - BT_ID_error_1) >= device->history_count)
                return BT_ABORT_NO_DATA;
            number->u = device->history[id - BT_ID_error_1];
        } else {
            *number = bt_load(variables, id);
        }
        break;
    }
    return BT_OK;
}

const char *bt_text(const struct bt_device *device, enum bt_id id)
{
    const char *own = id == BT_ID_device_name        ? device->config.device_name
                      : id == BT_ID_hardware_version ? device->config.hardware_version
                      : id == BT_ID_firmware_version ? device->config.firmware_version
                                                     : NULL;
    return own ? own : bt_entries[id].initial.text;
}

uint32_t bt_read(const struct bt_device *device, uint16_t index, uint8_t sub, struct bt_value *value)
{
    union bt_number number;
    enum bt_id id;
    uint32_t status = bt_find(index, sub, &id);
    memset(value, 0, sizeof *value);
    if (status != BT_OK)
        return status;
    if (bt_entries[id].access == BT_ACCESS_WO)
        return BT_ABORT_WRITE_ONLY;
    if (bt_entries[id].type == BT_TYPE_STRING) {
        value->text = bt_text(device, id);
        value->n = strlen(value->text);
        return BT_OK;
    }
    if (id == BT_ID_capture_data) {
        if (!bt_capture_is_complete(&device->capture, device->capture.sequence))
            return BT_ABORT_DEVICE_STATE;
        value->is_capture = true;
        value->n = bt_capture_size(&device->capture);
        return BT_OK;
    }
    BT_LOCK();
    status = bt_number(device, id, &number);
    BT_UNLOCK();
    if (status == BT_OK)
        value->n = bt_encode(id, number, value->number);
    return status;
}

void bt_value_copy(struct bt_device *device, const struct bt_value *value, size_t from, uint8_t *data, size_t n)
{
    if (value->is_capture)
        bt_capture_read(&device->capture, device->config.tick_period_ns, from, data, n);
    else
        memcpy(data, (value->text ? (const uint8_t *)value->text : value->number) + from, n);
}

/* ---- writing -------------------------------------------------------------------------------------------- */

/* What could not be kept is not in force after a reset either. */
static uint32_t save(struct bt_device *device)
{
    uint32_t words[BT_STORED_WORDS] = { BT_DICTIONARY_HASH };
    uint32_t id, place = 1;
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        if (bt_entries[id].role == BT_ROLE_PARAMETER)
            words[place++] = bt_load(&device->variables, (enum bt_id)id).u;
    }
    if (device->config.save && !device->config.save(device->config.context, words, place))
        return ABORT_HARDWARE;
    memcpy(device->stored, words, sizeof device->stored);
    device->has_stored = true;
    return BT_OK;
}

static uint32_t forget(struct bt_device *device)
{
    if (device->config.save && !device->config.save(device->config.context, device->stored, 0))
        return ABORT_HARDWARE;
    device->has_stored = false;
    return BT_OK;
}

static bool is_supported(const struct bt_device *device, int32_t mode)
{
    return device->variables.supported_modes & BT_MODE_BIT(mode);
}

/* What an entry demands besides its limits. */
static uint32_t check(const struct bt_device *device, enum bt_id id, union bt_number number)
{
    switch (id) {
    case BT_ID_controlword:
        return bt_device_check_control(device, (uint16_t)number.u);
    case BT_ID_capture_control:
        return number.u == BT_CAPTURE_CONTROL_ARM ? bt_capture_check(&device->variables) : BT_OK;
    case BT_ID_stimulus_control: /* none is played here */
        if (number.u != BT_STIMULUS_CONTROL_START)
            return BT_OK;
        return device->state == BT_STATE_OPERATION_ENABLED ? BT_ABORT_DEVICE_INCOMPATIBLE : BT_ABORT_DEVICE_STATE;
    case BT_ID_mode_of_operation:
        if (!is_supported(device, number.i))
            return BT_ABORT_VALUE;
        if (bt_cia402_power_stage_on((enum bt_state)device->state) && !bt_device_has_angle(device, number.i))
            return BT_ABORT_DEVICE_STATE;
        return BT_OK;
    case BT_ID_error_history_count:
        return number.u == 0 ? BT_OK : BT_ABORT_VALUE;
    case BT_ID_store_all:
        return number.u == SIGNATURE_SAVE ? BT_OK : BT_ABORT_NOT_STORED;
    case BT_ID_restore_all:
        return number.u == SIGNATURE_LOAD ? BT_OK : BT_ABORT_NOT_STORED;
    case BT_ID_host_heartbeat:
        return (number.u & 0xFFFFu) > BT_LONGEST_TIMEOUT_MS ? BT_ABORT_VALUE_HIGH : BT_OK;
    case BT_ID_parameter_trial: /* ends with the link, which must be there for that */
        return number.u == BT_PARAMETER_TRIAL_OFF || device->watchdog.state == BT_LINK_STATE_ALIVE
                   ? BT_OK
                   : BT_ABORT_DEVICE_STATE;
    default:
        return bt_pdo_check(&device->variables, id, number.u);
    }
}

static uint32_t accept(const struct bt_device *device, enum bt_id id, const uint8_t *data, size_t n,
                       union bt_number *number)
{
    uint32_t status;
    if (bt_entries[id].access != BT_ACCESS_RW && bt_entries[id].access != BT_ACCESS_WO)
        return BT_ABORT_READ_ONLY;
    status = bt_decode(id, data, n, number);
    if (status != BT_OK)
        return status;
    if (!(bt_entries[id].flags & BT_FLAG_ENABLED_WRITE) &&
        bt_cia402_power_stage_on((enum bt_state)device->state))
        return BT_ABORT_DEVICE_STATE;
    status = check(device, id, *number);
    return status == BT_OK ? bt_check_relations(&device->variables, NULL, id, *number) : status;
}

uint32_t bt_check(const struct bt_device *device, enum bt_id id, const uint8_t *data, size_t n)
{
    union bt_number number;
    return accept(device, id, data, n, &number);
}

/* What can fail though the value may be written. */
static uint32_t perform(struct bt_device *device, enum bt_id id)
{
    return id == BT_ID_store_all ? save(device) : id == BT_ID_restore_all ? forget(device) : BT_OK;
}

/* What follows a write in other variables, with the lock held: the control interrupt sees them change together. */
static void follow(struct bt_device *device, enum bt_id id, union bt_number number)
{
    struct bt_variables *variables = &device->variables;
    switch (id) {
    case BT_ID_mode_of_operation:
        if (variables->mode_of_operation_display != number.i)
            bt_device_zero_targets(device);
        variables->mode_of_operation_display = (int8_t)number.i;
        break;
    case BT_ID_offset_calibration:
        if (number.u == BT_OFFSET_CALIBRATION_START)
            bt_currents_start(&device->currents, variables);
        else
            bt_currents_stop(&device->currents);
        break;
    case BT_ID_target_torque:
        variables->torque_command = (float)number.i * 1e-3f * variables->T_N;
        break;
    case BT_ID_max_torque:
        variables->torque_limit = (float)number.u * 1e-3f * variables->T_N;
        break;
    case BT_ID_target_velocity:
        variables->omega_m_command = (float)number.i * 1e-3f;
        break;
    default:
        break;
    }
}

static void effect(struct bt_device *device, enum bt_id id, union bt_number number)
{
    switch (id) {
    case BT_ID_controlword:
        bt_device_control(device, (uint16_t)number.u);
        break;
    case BT_ID_capture_control:
        if (number.u == BT_CAPTURE_CONTROL_ARM)
            bt_capture_arm(&device->capture, &device->variables);
        else
            bt_capture_abort(&device->capture);
        break;
    case BT_ID_error_history_count:
        device->history_count = 0;
        break;
    case BT_ID_host_heartbeat:
        bt_watchdog_configure(&device->watchdog, number.u, device->config.tick_period_ns);
        break;
    default:
        break;
    }
}

uint32_t bt_write(struct bt_device *device, uint16_t index, uint8_t sub, const uint8_t *data, size_t n)
{
    union bt_number number;
    enum bt_id id;
    uint32_t status = bt_find(index, sub, &id);
    if (status == BT_OK)
        status = accept(device, id, data, n, &number);
    if (status == BT_OK)
        status = perform(device, id);
    if (status != BT_OK)
        return status;
    BT_LOCK();
    bt_store(&device->variables, id, number);
    follow(device, id, number);
    BT_UNLOCK();
    effect(device, id, number);
    return BT_OK;
}

uint32_t bt_take_setpoint(struct bt_device *device, const uint8_t torque[4], const uint8_t omega_m[4])
{
    union bt_number both[2];
    uint32_t status = bt_decode(BT_ID_torque_command, torque, 4, &both[0]);
    if (status == BT_OK)
        status = bt_decode(BT_ID_omega_m_command, omega_m, 4, &both[1]);
    if (status == BT_OK) {
        BT_LOCK();
        device->variables.torque_command = both[0].f;
        device->variables.omega_m_command = both[1].f;
        BT_UNLOCK();
    }
    return status;
}

bool bt_preset(struct bt_device *device, const uint32_t *raw, size_t n)
{
    uint32_t id, place = 1;
    device->has_stored = false;
    if (n != BT_STORED_WORDS || raw[0] != BT_DICTIONARY_HASH)
        return false;
    for (id = 0; id < BT_ENTRY_COUNT; id++) {
        union bt_number number;
        uint8_t data[4];
        if (bt_entries[id].role != BT_ROLE_PARAMETER)
            continue;
        number.u = raw[place++];
        if (bt_decode((enum bt_id)id, data, bt_encode((enum bt_id)id, number, data), &number) != BT_OK ||
            bt_check_relations(&device->variables, raw + 1, (enum bt_id)id, number) != BT_OK)
            return false;
    }
    memcpy(device->stored, raw, sizeof device->stored);
    device->has_stored = true;
    return true;
}
