/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* What outlives a reset, and what the firmware says of itself: kept parameters, identity, modes. */
#undef NDEBUG
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "bt_bytes.h"
#include "check.h"
#include "host.h"

#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu
#define ABORT_HARDWARE 0x06060000u

static struct bt_drive drive;

static struct memory {
    bool works;
    size_t n;
    uint32_t words[BT_STORED_WORDS];
} memory;

static bool keep(void *context, const uint32_t *raw, size_t n)
{
    struct memory *to = context;
    if (!to->works)
        return false;
    assert(n == 0 || n == BT_STORED_WORDS);
    memcpy(to->words, raw, n * sizeof *raw);
    to->n = n;
    return true;
}

static void power_up(void)
{
    struct bt_config config = check_config();
    config.save = keep;
    config.context = &memory;
    check_power_up_as(&drive, &config);
}

static uint32_t R_s_after_reset(void)
{
    host_nmt(&drive, BT_NMT_RESET_NODE);
    return host_read(&drive, BT_ID_R_s);
}

/* What is refused is not in force after a reset: neither a save nor a restore of the defaults. */
static void check_save(void)
{
    const uint32_t initial = bt_word_of(bt_entries[BT_ID_R_s].initial.f);
    memory.works = false;
    power_up();
    assert(host_write(&drive, BT_ID_store_all, 0x65766172u) == BT_ABORT_NOT_STORED);
    assert(host_write(&drive, BT_ID_R_s, bt_word_of(0.5f)) == BT_OK);
    assert(host_write(&drive, BT_ID_store_all, SAVE) == ABORT_HARDWARE);
    assert(R_s_after_reset() == initial);

    memory.works = true;
    assert(host_write(&drive, BT_ID_R_s, bt_word_of(0.5f)) == BT_OK);
    assert(host_write(&drive, BT_ID_store_all, SAVE) == BT_OK);
    assert(host_write(&drive, BT_ID_R_s, bt_word_of(0.7f)) == BT_OK);
    memory.works = false;
    assert(host_write(&drive, BT_ID_store_all, SAVE) == ABORT_HARDWARE);
    assert(R_s_after_reset() == bt_word_of(0.5f));
    assert(host_write(&drive, BT_ID_restore_all, LOAD) == ABORT_HARDWARE);
    assert(R_s_after_reset() == bt_word_of(0.5f));
    memory.works = true;
    assert(host_write(&drive, BT_ID_restore_all, LOAD) == BT_OK && memory.n == 0);
    assert(R_s_after_reset() == initial);
}

/* Control never sees the default of a parameter that was kept, not even while a reset is under way. */
static void check_reset(void)
{
    power_up();
    assert(host_write(&drive, BT_ID_R_s, bt_word_of(0.5f)) == BT_OK);
    assert(host_write(&drive, BT_ID_store_all, SAVE) == BT_OK);
    assert(memory.n == BT_STORED_WORDS && memory.words[0] == BT_DICTIONARY_HASH);
    power_up();
    assert(bt_restore(&drive, memory.words, memory.n));
    assert(host_read(&drive, BT_ID_R_s) == bt_word_of(0.5f));
    assert(R_s_after_reset() == bt_word_of(0.5f));
}

/* A trial is taken while the host is heard, ends with the host, and needs no reset; parameters without one stay. */
static void check_trial(void)
{
    unsigned trial, ticks;
    for (trial = BT_PARAMETER_TRIAL_OFF; trial <= BT_PARAMETER_TRIAL_ON; trial++) {
        memory.works = true;
        power_up();
        assert(host_write(&drive, BT_ID_R_s, bt_word_of(0.5f)) == BT_OK);
        assert(host_write(&drive, BT_ID_store_all, SAVE) == BT_OK);
        assert(host_write(&drive, BT_ID_parameter_trial, BT_PARAMETER_TRIAL_ON) == BT_ABORT_DEVICE_STATE);
        assert(host_write(&drive, BT_ID_host_heartbeat, (uint32_t)127 << 16 | 500) == BT_OK);
        host_nmt(&drive, BT_NMT_START);
        host_heartbeat(&drive);
        assert(host_write(&drive, BT_ID_parameter_trial, trial) == BT_OK);
        assert(host_write(&drive, BT_ID_R_s, bt_word_of(0.7f)) == BT_OK);
        for (ticks = 0; ticks < 496; ticks++)
            bt_tick(&drive);
        assert(host_read(&drive, BT_ID_R_s) == bt_word_of(0.7f));
        bt_tick(&drive);
        assert(host_read(&drive, BT_ID_link_state) == BT_LINK_STATE_LOST);
        assert(host_read(&drive, BT_ID_R_s) == bt_word_of(trial ? 0.5f : 0.7f));
        assert(host_read(&drive, BT_ID_parameter_trial) == BT_PARAMETER_TRIAL_OFF);
    }
}

/* Values of another table, though they are as many, of the format without a hash, or out of their limits. */
static void check_restore(void)
{
    const uint32_t initial = bt_word_of(bt_entries[BT_ID_R_s].initial.f);
    uint32_t words[BT_STORED_WORDS];
    unsigned k;
    for (k = 0; k < 4; k++) {
        memcpy(words, memory.words, sizeof words);
        if (k == 0)
            words[0] ^= 1u;
        if (k == 2)
            memset(words + 1, 0xFF, sizeof words - sizeof *words);
        power_up();
        assert(bt_restore(&drive, memory.words, memory.n));
        if (k == 1)
            assert(!bt_restore(&drive, words + 1, BT_PARAMETER_COUNT));
        else if (k == 3)
            assert(!bt_restore(&drive, words, 0));
        else
            assert(!bt_restore(&drive, words, BT_STORED_WORDS));
        assert(host_read(&drive, BT_ID_R_s) == initial && R_s_after_reset() == initial);
    }
}

static void check_identity(void)
{
    struct bt_config config = check_config();
    check_power_up_as(&drive, &config);
    assert(host_read(&drive, BT_ID_vendor_id) == BT_VENDOR_ID);
    assert(host_read(&drive, BT_ID_product_code) == BT_PRODUCT_CODE);
    assert(host_read(&drive, BT_ID_revision_number) == BT_REVISION);
    config.vendor_id = 0x123u;
    config.product_code = 0x456u;
    config.revision_number = 0x789u;
    check_power_up_as(&drive, &config);
    host_nmt(&drive, BT_NMT_RESET_NODE);
    assert(host_read(&drive, BT_ID_vendor_id) == 0x123u && host_read(&drive, BT_ID_product_code) == 0x456u);
    assert(host_read(&drive, BT_ID_revision_number) == 0x789u);
}

/* A drive takes the modes that its firmware serves; without a word of it velocity and torque. */
static void check_modes(void)
{
    struct bt_config config = check_config();
    check_power_up_as(&drive, &config);
    assert(host_read(&drive, BT_ID_supported_modes) == 0x0Cu);
    assert(host_write(&drive, BT_ID_mode_of_operation, (uint8_t)-1) == BT_ABORT_VALUE);
    assert(host_write(&drive, BT_ID_mode_of_operation, 2) == BT_ABORT_VALUE);
    assert(host_write(&drive, BT_ID_mode_of_operation, 3) == BT_OK);
    assert(host_read(&drive, BT_ID_mode_of_operation_display) == 3);

    config.supported_modes = BT_MODE_BIT(BT_MODE_OF_OPERATION_VELOCITY);
    check_power_up_as(&drive, &config);
    assert(host_read(&drive, BT_ID_mode_of_operation) == 3 && host_read(&drive, BT_ID_mode_of_operation_display) == 3);
    assert(host_write(&drive, BT_ID_mode_of_operation, 4) == BT_ABORT_VALUE);

    config.supported_modes = 0x1000Cu;
    check_power_up_as(&drive, &config);
    assert(host_write(&drive, BT_ID_mode_of_operation, (uint8_t)-1) == BT_OK);
    assert(host_read(&drive, BT_ID_mode_of_operation_display) == 0xFFu);
    assert(host_write(&drive, BT_ID_mode_of_operation, (uint8_t)BT_MODE_OF_OPERATION_CURRENT) == BT_ABORT_VALUE);

    config.supported_modes = 0x3000Cu;
    check_power_up_as(&drive, &config);
    assert(host_write(&drive, BT_ID_mode_of_operation, (uint8_t)BT_MODE_OF_OPERATION_CURRENT) == BT_OK);
}

void check_storage(void)
{
    check_save();
    check_reset();
    check_restore();
    check_trial();
    check_identity();
    check_modes();
    printf("storage: saves that fail, trials, values of another table, identity, modes\n");
}
