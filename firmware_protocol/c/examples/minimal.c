/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The least that a firmware is: compiled for a Cortex-M4 by `make size`. The functions of the board are declared
 * here only; they belong to the firmware. */
#include "benchtool.h"

extern float adc_current(unsigned phase);
extern float encoder_speed(void);
extern bool stands_or_turns_back(float omega_m);
extern float braking_torque(float omega_m);
extern void pwm(bool on, float torque);
extern size_t uart_room(void);
extern void uart_put(const uint8_t *data, size_t n);
void control_interrupt(void);
void uart_received(uint8_t byte);
void break_interrupt(void);
int main(void);

static struct bt_drive drive;

/* The trip level is at most the converter's range, at whose end a current may be any; no number is not within it. */
static bool is_within(float current)
{
    const struct bt_variables *v = bt_variables(&drive);
    return current <= v->i_trip && current >= -v->i_trip && current < v->i_full_scale && current > -v->i_full_scale;
}

void control_interrupt(void)
{
    struct bt_variables *v = bt_variables(&drive);
    float torque;
    v->i_a = adc_current(0);
    v->i_b = adc_current(1);
    v->i_c = adc_current(2);
    v->omega_m = encoder_speed();
    if (!is_within(v->i_a) || !is_within(v->i_b) || !is_within(v->i_c))
        bt_trip(&drive, BT_ERROR_OVERCURRENT);
    if (bt_is_quick_stopping(&drive) && stands_or_turns_back(v->omega_m))
        bt_standstill(&drive);
    torque = bt_is_quick_stopping(&drive) ? braking_torque(v->omega_m) : bt_torque_setpoint(&drive);
    pwm(bt_may_switch(&drive), torque);
    bt_tick(&drive);
}

void break_interrupt(void)
{
    bt_trip(&drive, BT_ERROR_OVERCURRENT);
}

void uart_received(uint8_t byte)
{
    bt_receive(&drive, &byte, 1);
}

int main(void)
{
    struct bt_config config = { 0 };
    uint8_t data[64];
    config.tick_period_ns = 100000u;
    config.node_id = 1;
    config.i_full_scale = 20.0f;
    config.u_dc_full_scale = 60.0f;
    config.vendor_id = 0x00000B7Cu;
    config.product_code = 0x00001234u;
    config.supported_modes = BT_MODE_BIT(BT_MODE_OF_OPERATION_TORQUE);
    bt_init(&drive, &config);
    for (;;) {
        size_t room = uart_room();
        bt_poll(&drive);
        uart_put(data, bt_transmit(&drive, data, room < sizeof data ? room : sizeof data));
    }
}
