/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_currents.h"

#include "bt_bytes.h"

#define OF_RANGE 0.1f /* of the sensors' range: an offset beyond it is that of a broken sensor, or a current */

void bt_currents_start(struct bt_currents *currents, const struct bt_variables *variables)
{
    currents->taken = 0;
    currents->ticks = variables->offset_calibration_ticks;
    currents->mean[0] = currents->mean[1] = currents->mean[2] = 0.0f;
    currents->state = BT_OFFSET_CALIBRATION_STATE_RUNNING;
}

void bt_currents_stop(struct bt_currents *currents)
{
    if (currents->state == BT_OFFSET_CALIBRATION_STATE_RUNNING)
        currents->state = BT_OFFSET_CALIBRATION_STATE_IDLE;
}

/* Of a sensor whose range is not known any number will do. */
static bool may_be_offset(float mean, float full_scale)
{
    const float size = mean < 0.0f ? -mean : mean;
    return full_scale > 0.0f ? size <= OF_RANGE * full_scale : bt_is_finite(mean);
}

static void finish(struct bt_currents *currents, struct bt_variables *variables)
{
    unsigned k;
    for (k = 0; k < 3; k++) {
        if (!may_be_offset(currents->mean[k], variables->i_full_scale)) {
            currents->state = BT_OFFSET_CALIBRATION_STATE_FAILED;
            return;
        }
    }
    variables->current_offset_a = currents->mean[0];
    variables->current_offset_b = currents->mean[1];
    variables->current_offset_c = currents->mean[2];
    currents->state = BT_OFFSET_CALIBRATION_STATE_DONE;
}

static void calibrate(struct bt_currents *currents, struct bt_variables *variables, const float reading[3])
{
    unsigned k;
    currents->taken++;
    for (k = 0; k < 3; k++)
        currents->mean[k] += (reading[k] - currents->mean[k]) / (float)currents->taken;
    if (currents->taken >= currents->ticks)
        finish(currents, variables);
}

void bt_currents_take(struct bt_currents *currents, struct bt_variables *variables, const float reading[3],
                      bool power_stage_on)
{
    const bool swapped = variables->phase_order == BT_PHASE_ORDER_ACB;
    float b, c;
    if (power_stage_on)
        bt_currents_stop(currents);
    if (currents->state == BT_OFFSET_CALIBRATION_STATE_RUNNING)
        calibrate(currents, variables, reading);
    b = (reading[1] - variables->current_offset_b) * variables->current_gain_b;
    c = (reading[2] - variables->current_offset_c) * variables->current_gain_c;
    variables->i_a = (reading[0] - variables->current_offset_a) * variables->current_gain_a;
    variables->i_b = swapped ? c : b;
    variables->i_c = swapped ? b : c;
}
