/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "toy_motor.h"

#include <math.h>

#define PI 3.14159265f
#define TORQUE_LAG_S 2e-3f
#define FRICTION_Nms 5e-5f
#define INERTIA_kgm2 1e-3f /* where the parameter does not state one */
#define RIPPLE 0.02f
#define STANDSTILL 0.01f /* of the rated speed */
#define U_DC_V 122.5f

static float torque_Nm, omega_m, theta_m;
static double heat; /* of the winding by I2t, in parts of what i2t_current makes at length */
static float braking_from; /* rad/s, the speed at which a quick stop began; 0: none is under way */

static float within(float value, float limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

/* Brakes; at standstill, or when the shaft has turned back since, the quick stop has come to its end. */
static float brake(struct bt_drive *drive)
{
    const struct bt_variables *v = bt_variables(drive);
    if (braking_from == 0.0f)
        braking_from = omega_m;
    if (braking_from * omega_m <= 0.0f || fabsf(omega_m) <= STANDSTILL * v->omega_m_N)
        bt_standstill(drive);
    return -v->K_p_speed * omega_m;
}

/* The torque that is asked for, by mode. A halt is a speed or torque of zero, which the setpoints are then. */
static float reference_of(struct bt_drive *drive)
{
    const struct bt_variables *v = bt_variables(drive);
    if (bt_is_quick_stopping(drive))
        return brake(drive);
    braking_from = 0.0f;
    switch (v->mode_of_operation_display) {
    case BT_MODE_OF_OPERATION_VELOCITY:
        return v->K_p_speed * (bt_omega_m_setpoint(drive) - omega_m);
    case BT_MODE_OF_OPERATION_TORQUE:
        return bt_torque_setpoint(drive);
    default:
        return 0.0f;
    }
}

static void control(struct bt_drive *drive)
{
    struct bt_variables *v = bt_variables(drive);
    const float T_s = v->control_period;
    const float J = v->J > 0.0f ? v->J : INERTIA_kgm2;
    const float reference = reference_of(drive);
    const bool on = bt_may_switch(drive); /* not in the tick in which a quick stop has come to its end */
    v->torque_reference = on ? within(reference, v->torque_limit) : 0.0f;
    v->law_clipped += on && v->torque_reference != reference;
    torque_Nm = on ? torque_Nm + (v->torque_reference - torque_Nm) * fminf(1.0f, T_s / TORQUE_LAG_S) : 0.0f;
    omega_m += (torque_Nm - FRICTION_Nms * omega_m) / J * T_s;
    theta_m = fmodf(theta_m + omega_m * T_s, 2.0f * PI);
    theta_m += theta_m < 0.0f ? 2.0f * PI : 0.0f;
}

/* A phase current as a converter of limited range tells it. */
static float sampled(struct bt_variables *v, float current)
{
    if (v->i_full_scale <= 0.0f || fabsf(current) < v->i_full_scale)
        return current;
    v->adc_saturated++;
    return within(current, v->i_full_scale);
}

/* Amplitude-invariant vectors in the stator frame from those of the rotor. */
static void measure(struct bt_drive *drive)
{
    struct bt_variables *v = bt_variables(drive);
    const float p = (float)v->pole_pairs, theta_e = p * theta_m;
    const float c = cosf(theta_e), s = sinf(theta_e);
    const float torque = torque_Nm * (1.0f + RIPPLE * cosf(6.0f * theta_e));
    const float i_q = v->psi_r > 0.0f ? torque / (1.5f * p * v->psi_r) : 0.0f;
    const float u_d = -p * omega_m * v->L_q * i_q, u_q = v->R_s * i_q + p * omega_m * v->psi_r;
    float reading[3];
    v->i_d = 0.0f;
    v->i_q = i_q;
    reading[0] = sampled(v, -i_q * s);
    reading[1] = sampled(v, 0.5f * i_q * s + 0.8660254f * i_q * c);
    reading[2] = sampled(v, 0.5f * i_q * s - 0.8660254f * i_q * c);
    bt_take_currents(drive, reading);
    v->u_alpha = u_d * c - u_q * s;
    v->u_beta = u_d * s + u_q * c;
    v->u_dc = U_DC_V;
    v->theta_m = theta_m;
    v->omega_m = omega_m;
    v->torque = torque;
    v->psi_alpha = v->psi_r * c - v->L_q * i_q * s;
    v->psi_beta = v->psi_r * s + v->L_q * i_q * c;
    v->psi_s = sqrtf(v->psi_alpha * v->psi_alpha + v->psi_beta * v->psi_beta);
    v->psi_s_reference = v->psi_s;
    v->law_angle = atan2f(v->L_q * i_q, v->psi_r);
    v->switching_count += bt_may_switch(drive) ? 6u : 0u;
}

/* What reads the end of a converter's range may be anything beyond it. 0: the range is not known. */
static bool is_at_the_end(float value, float full_scale)
{
    return full_scale > 0.0f && fabsf(value) >= full_scale;
}

/* One thermal time constant. A current that is no number heats like a very large one. */
static void warm(struct bt_variables *v)
{
    const double square = 2.0 / 3.0 * ((double)v->i_a * v->i_a + (double)v->i_b * v->i_b + (double)v->i_c * v->i_c);
    const double borne = (double)v->i2t_current * v->i2t_current;
    const double target = square <= 1e6 * borne && borne > 0.0 ? square / borne : 1e6;
    heat += (double)v->control_period / (double)v->i2t_tau * (target - heat);
    v->i2t_level = (float)heat;
}

/* Each level is asked for what is within it, so that a measurement which is no number trips. */
static void protect(struct bt_drive *drive)
{
    struct bt_variables *v = bt_variables(drive);
    const float currents[] = { v->i_a, v->i_b, v->i_c };
    const bool on = bt_may_switch(drive);
    unsigned k;
    for (k = 0; k < 3; k++) {
        if (!(fabsf(currents[k]) <= v->i_trip) || (on && is_at_the_end(currents[k], v->i_full_scale)))
            bt_trip(drive, BT_ERROR_OVERCURRENT);
    }
    if (!(fabsf(v->omega_m) <= v->omega_m_trip))
        bt_trip(drive, BT_ERROR_OVERSPEED);
    if (on && !(v->u_dc >= v->u_dc_min))
        bt_trip(drive, BT_ERROR_DC_LINK_UNDERVOLTAGE);
    if (!(v->u_dc <= v->u_dc_max) || is_at_the_end(v->u_dc, v->u_dc_full_scale))
        bt_trip(drive, BT_ERROR_DC_LINK_OVERVOLTAGE);
    warm(v);
    if (!(heat <= 1.0))
        bt_trip(drive, BT_ERROR_OVERLOAD);
    if (!(v->winding_temperature <= v->temperature_trip))
        bt_trip(drive, BT_ERROR_TEMPERATURE);
}

void toy_motor_tick(struct bt_drive *drive)
{
    control(drive);
    measure(drive);
    protect(drive);
    bt_tick(drive);
}

void toy_motor_at_rest(void)
{
    torque_Nm = omega_m = theta_m = braking_from = 0.0f;
    heat = 0.0;
}
