/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Readings of the current sensors become currents of the phases, and their offsets are calibrated. */
#undef NDEBUG
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "bt_bytes.h"
#include "check.h"
#include "host.h"

#define TICKS 8u

static struct bt_drive drive;

static float offset(enum bt_id id)
{
    return bt_float_of(host_read(&drive, id));
}

/* Readings that swing about their offset. */
static void take(unsigned ticks, float offset_a)
{
    unsigned k;
    for (k = 0; k < ticks; k++) {
        const float swing = k % 2u ? 0.25f : -0.25f;
        const float reading[] = { offset_a + swing, 0.5f - swing, -0.125f };
        bt_take_currents(&drive, reading);
        bt_tick(&drive);
    }
}

static uint32_t calibrated(float offset_a)
{
    assert(host_write(&drive, BT_ID_offset_calibration_ticks, TICKS) == BT_OK);
    assert(host_write(&drive, BT_ID_offset_calibration, BT_OFFSET_CALIBRATION_START) == BT_OK);
    take(TICKS - 1u, offset_a);
    assert(host_read(&drive, BT_ID_offset_calibration_state) == BT_OFFSET_CALIBRATION_STATE_RUNNING);
    take(1u, offset_a + 0.5f); /* the swing that is still missing, and that of this tick */
    return host_read(&drive, BT_ID_offset_calibration_state);
}

static void check_calibration(void)
{
    struct bt_config config = check_config();
    config.i_full_scale = 12.0f;
    check_power_up_as(&drive, &config);
    assert(calibrated(1.0f) == BT_OFFSET_CALIBRATION_STATE_DONE);
    assert(fabsf(offset(BT_ID_current_offset_a) - 1.0f) < 1e-6f);
    assert(fabsf(offset(BT_ID_current_offset_b) - 0.5625f) < 1e-6f); /* five readings above it, three below */
    assert(fabsf(offset(BT_ID_current_offset_c) + 0.125f) < 1e-6f);

    assert(calibrated(1.3f) == BT_OFFSET_CALIBRATION_STATE_FAILED); /* beyond a tenth of the range */
    assert(calibrated(NAN) == BT_OFFSET_CALIBRATION_STATE_FAILED);
    assert(fabsf(offset(BT_ID_current_offset_a) - 1.0f) < 1e-6f);

    check_power_up(&drive); /* the range is not known */
    assert(calibrated(3.0f) == BT_OFFSET_CALIBRATION_STATE_DONE);
    assert(calibrated(INFINITY) == BT_OFFSET_CALIBRATION_STATE_FAILED);
}

/* It needs the power stage off, and ends with it going on, with a stop and with a reset. */
static void check_end(void)
{
    check_power_up(&drive);
    host_enable(&drive);
    assert(host_write(&drive, BT_ID_offset_calibration, BT_OFFSET_CALIBRATION_START) == BT_ABORT_DEVICE_STATE);
    assert(host_write(&drive, BT_ID_controlword, 0) == BT_OK);

    assert(host_write(&drive, BT_ID_offset_calibration, BT_OFFSET_CALIBRATION_START) == BT_OK);
    host_enable(&drive);
    take(1u, 1.0f);
    assert(host_read(&drive, BT_ID_offset_calibration_state) == BT_OFFSET_CALIBRATION_STATE_IDLE);
    assert(host_write(&drive, BT_ID_controlword, 0) == BT_OK);

    assert(host_write(&drive, BT_ID_offset_calibration, BT_OFFSET_CALIBRATION_START) == BT_OK);
    assert(host_write(&drive, BT_ID_offset_calibration, BT_OFFSET_CALIBRATION_STOP) == BT_OK);
    assert(host_read(&drive, BT_ID_offset_calibration_state) == BT_OFFSET_CALIBRATION_STATE_IDLE);
    assert(host_write(&drive, BT_ID_offset_calibration, BT_OFFSET_CALIBRATION_START) == BT_OK);
    host_nmt(&drive, BT_NMT_RESET_NODE);
    assert(host_read(&drive, BT_ID_offset_calibration_state) == BT_OFFSET_CALIBRATION_STATE_IDLE);
    take(TICKS, 1.0f);
    assert(offset(BT_ID_current_offset_a) == 0.0f);
}

static void check_correction(void)
{
    const float reading[] = { 3.0f, 5.0f, -9.0f };
    struct bt_variables *variables = bt_variables(&drive);
    check_power_up(&drive);
    bt_take_currents(&drive, reading);
    assert(variables->i_a == 3.0f && variables->i_b == 5.0f && variables->i_c == -9.0f);
    assert(host_write(&drive, BT_ID_current_offset_a, bt_word_of(1.0f)) == BT_OK);
    assert(host_write(&drive, BT_ID_current_gain_b, bt_word_of(1.5f)) == BT_OK);
    assert(host_write(&drive, BT_ID_phase_order, BT_PHASE_ORDER_ACB) == BT_OK);
    bt_take_currents(&drive, reading);
    assert(variables->i_a == 2.0f && variables->i_b == -9.0f && variables->i_c == 7.5f);
}

void check_currents(void)
{
    check_calibration();
    check_end();
    check_correction();
    printf("currents: calibration and its ends, correction, phase order\n");
}
