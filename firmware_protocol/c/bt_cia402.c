/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_cia402.h"

enum command { SHUTDOWN, SWITCH_ON, ENABLE_OPERATION, DISABLE_VOLTAGE, QUICK_STOP, COMMAND_COUNT };

/* The bits of the controlword that tell a command, and their values. "Switch on" is also "disable operation". */
static const struct {
    uint8_t mask, bits;
} commands[COMMAND_COUNT] = {
    [SHUTDOWN] = { 0x87, 0x06 },        [SWITCH_ON] = { 0x8F, 0x07 },  [ENABLE_OPERATION] = { 0x8F, 0x0F },
    [DISABLE_VOLTAGE] = { 0x82, 0x00 }, [QUICK_STOP] = { 0x86, 0x02 },
};

/* What a command does in a state; 0, which no command leads to, where it does nothing. */
static const uint8_t transitions[BT_STATE_COUNT][COMMAND_COUNT] = {
    [BT_STATE_SWITCH_ON_DISABLED] = { [SHUTDOWN] = BT_STATE_READY_TO_SWITCH_ON },
    [BT_STATE_READY_TO_SWITCH_ON] = { [SWITCH_ON] = BT_STATE_SWITCHED_ON,
                                      [ENABLE_OPERATION] = BT_STATE_OPERATION_ENABLED,
                                      [DISABLE_VOLTAGE] = BT_STATE_SWITCH_ON_DISABLED,
                                      [QUICK_STOP] = BT_STATE_SWITCH_ON_DISABLED },
    [BT_STATE_SWITCHED_ON] = { [SHUTDOWN] = BT_STATE_READY_TO_SWITCH_ON,
                               [ENABLE_OPERATION] = BT_STATE_OPERATION_ENABLED,
                               [DISABLE_VOLTAGE] = BT_STATE_SWITCH_ON_DISABLED,
                               [QUICK_STOP] = BT_STATE_SWITCH_ON_DISABLED },
    [BT_STATE_OPERATION_ENABLED] = { [SHUTDOWN] = BT_STATE_READY_TO_SWITCH_ON,
                                     [SWITCH_ON] = BT_STATE_SWITCHED_ON,
                                     [DISABLE_VOLTAGE] = BT_STATE_SWITCH_ON_DISABLED,
                                     [QUICK_STOP] = BT_STATE_QUICK_STOP_ACTIVE },
    [BT_STATE_QUICK_STOP_ACTIVE] = { [DISABLE_VOLTAGE] = BT_STATE_SWITCH_ON_DISABLED },
};

static const uint8_t status_bits[BT_STATE_COUNT] = {
    [BT_STATE_NOT_READY_TO_SWITCH_ON] = 0x00, [BT_STATE_SWITCH_ON_DISABLED] = 0x40,
    [BT_STATE_READY_TO_SWITCH_ON] = 0x21,     [BT_STATE_SWITCHED_ON] = 0x23,
    [BT_STATE_OPERATION_ENABLED] = 0x27,      [BT_STATE_QUICK_STOP_ACTIVE] = 0x07,
    [BT_STATE_FAULT_REACTION_ACTIVE] = 0x0F,  [BT_STATE_FAULT] = 0x08,
};

enum bt_state bt_cia402_transition(enum bt_state state, uint16_t controlword, uint16_t before)
{
    unsigned command;
    if ((unsigned)state >= BT_STATE_COUNT)
        return state;
    if (state == BT_STATE_FAULT)
        return controlword & ~(unsigned)before & BT_CONTROL_FAULT_RESET ? BT_STATE_SWITCH_ON_DISABLED : state;
    for (command = 0; command < COMMAND_COUNT; command++) {
        if ((controlword & commands[command].mask) == commands[command].bits) {
            const uint8_t after = transitions[state][command];
            return after ? (enum bt_state)after : state;
        }
    }
    return state;
}

uint16_t bt_cia402_statusword(enum bt_state state, uint16_t flags)
{
    return (uint16_t)(((unsigned)state < BT_STATE_COUNT ? status_bits[state] : 0u) | flags);
}

bool bt_cia402_power_stage_on(enum bt_state state)
{
    return state == BT_STATE_OPERATION_ENABLED || state == BT_STATE_QUICK_STOP_ACTIVE ||
           state == BT_STATE_FAULT_REACTION_ACTIVE;
}
