/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The power drive state machine of CiA 402-2 (IEC 61800-7-201) as total functions. */
#ifndef BT_CIA402_H
#define BT_CIA402_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum bt_state {
    BT_STATE_NOT_READY_TO_SWITCH_ON,
    BT_STATE_SWITCH_ON_DISABLED,
    BT_STATE_READY_TO_SWITCH_ON,
    BT_STATE_SWITCHED_ON,
    BT_STATE_OPERATION_ENABLED,
    BT_STATE_QUICK_STOP_ACTIVE,
    BT_STATE_FAULT_REACTION_ACTIVE,
    BT_STATE_FAULT,
    BT_STATE_COUNT
};

/* Bits of the controlword beside the commands. */
#define BT_CONTROL_FAULT_RESET 0x80u
#define BT_CONTROL_HALT 0x100u

/* Flags of the statusword besides the state. */
#define BT_STATUS_VOLTAGE_ENABLED 0x0010u
#define BT_STATUS_WARNING 0x0080u
#define BT_STATUS_REMOTE 0x0200u
#define BT_STATUS_TARGET_REACHED 0x0400u
#define BT_STATUS_INTERNAL_LIMIT 0x0800u

/* The state after `controlword` was written where `before` was: transitions 2 to 12 and 15. What a drive does by
 * itself (0, 1, 13, 14, the end of a quick stop) is not here. */
enum bt_state bt_cia402_transition(enum bt_state state, uint16_t controlword, uint16_t before);

uint16_t bt_cia402_statusword(enum bt_state state, uint16_t flags);

/* Whether the inverter may be switching. */
bool bt_cia402_power_stage_on(enum bt_state state);

#ifdef __cplusplus
}
#endif

#endif
