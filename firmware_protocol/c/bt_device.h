/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The drive behind its dictionary: states, faults, parameters that are kept, the rules of its objects. It knows
 * nothing of frames; a serial line and a CAN bus may both stand in front of it.
 *
 * Functions marked "control interrupt" may interrupt all others; the rest belong to the main loop, and take the lock
 * of bt_sync.h around what they share with it. bt_device_trip may be called from anywhere. */
#ifndef BT_DEVICE_H
#define BT_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bt_capture.h"
#include "bt_cia402.h"
#include "bt_currents.h"
#include "bt_dictionary.h"
#include "bt_version.h"
#include "bt_watchdog.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_ERROR_OVERCURRENT 0x2310u
#define BT_ERROR_OVERLOAD 0x2350u
#define BT_ERROR_DC_LINK_OVERVOLTAGE 0x3210u
#define BT_ERROR_DC_LINK_UNDERVOLTAGE 0x3220u
#define BT_ERROR_TEMPERATURE 0x4310u
#define BT_ERROR_HEARTBEAT 0x8130u
#define BT_ERROR_OVERSPEED 0x8400u

#define BT_HISTORY 8u

#define BT_IS_PARAMETER(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, low, high, initial) \
    +(BT_ROLE_##ROLE == BT_ROLE_PARAMETER)
enum { BT_PARAMETER_COUNT = 0 BT_ENTRIES(BT_IS_PARAMETER) };

/* Words of kept parameters: the hash of their dictionary, then their raw values in the order of the table. */
#define BT_STORED_WORDS (1u + BT_PARAMETER_COUNT)

/* The bit of a mode in supported_modes (object 0x6502): 0 to 15 are of CiA 402, from 16 on the drive's own. */
#define BT_MODE_BIT(mode) ((mode) > 0 ? 1u << ((mode) - 1) : 1u << (15 - (mode)))

/* What is the firmware's to say. */
struct bt_config {
    uint32_t tick_period_ns; /* of control; not 0 */
    uint32_t pwm_period_ns;  /* 0: that of control; with double update twice that */
    uint32_t vendor_id, product_code, revision_number; /* 0: those of the table */
    uint32_t serial_number;
    uint32_t supported_modes; /* BT_MODE_BIT of each; 0: velocity and torque */
    uint32_t first_tick;    /* that of power-up: 0, or just before 2^32 to test the wrap */
    float i_full_scale;       /* A, peak: what the current sensors reach; 0: not known, and no limit of i_trip */
    float u_dc_full_scale;    /* V: what the dc link's sensor reaches; 0: not known, and no limit of u_dc_max */
    uint8_t node_id;          /* 1 to 127 */
    const char *device_name, *hardware_version, *firmware_version; /* NULL: those of the table */
    /* Keeps n words for bt_preset; n is BT_STORED_WORDS, or 0 to forget them. Says whether it could; if not, what was
     * kept before is still in force. NULL: they are kept until power is lost. */
    bool (*save)(void *context, const uint32_t *raw, size_t n);
    void *context;
};

struct bt_device {
    struct bt_variables variables;
    struct bt_config config;
    struct bt_watchdog watchdog;
    struct bt_capture capture;
    struct bt_currents currents;
    volatile uint32_t tick_wraps; /* of the variable `tick`; of the control interrupt */
    volatile uint8_t state;       /* enum bt_state */
    volatile bool standstill;     /* a quick stop has braked */
    volatile bool rests;          /* a halt has come to its end, as of the last tick */
    volatile bool trip_edge;      /* since the last tick */
    volatile uint16_t trip_code;  /* 0: none; set by whoever trips, cleared by the main loop once it is in trip_seen */
    uint16_t trip_seen;           /* by the main loop */
    bool quick_stop_holds;        /* its option keeps the power stage on at standstill */
    volatile uint16_t controlword;
    uint16_t history[BT_HISTORY]; /* newest first */
    uint8_t history_count;
    bool has_stored;
    uint32_t stored[BT_STORED_WORDS];
    /* Takes every emergency the moment it arises. */
    void (*emergency)(void *context, uint16_t code, uint8_t error_register);
    void *emergency_context;
};

void bt_device_init(struct bt_device *device, const struct bt_config *config);

/* As after NMT reset node: power stage off, stored parameters in force. */
void bt_device_reset(struct bt_device *device);

/* What the control interrupt has found becomes a state: trips, a lost link, the end of a quick stop. */
void bt_device_look_after(struct bt_device *device);

/* Switch the power stage off without a fault, and forget the targets, as NMT stop does: to CiA 402 (0x6007) that is a
 * connection lost. */
void bt_device_stop(struct bt_device *device);

/* Whether a mode can do with what is known of the rotor: the firmware sets variable angle_known to 0 at power-up where
 * encoder_reference says so, and to 1 when the index has passed. */
bool bt_device_has_angle(const struct bt_device *device, int32_t mode);

/* Takes a controlword, or says why not; the same for what a write of the object does. */
uint32_t bt_device_check_control(const struct bt_device *device, uint16_t controlword);
void bt_device_control(struct bt_device *device, uint16_t controlword);

/* Ticks since power-up, which `tick` has modulo 2^32: what falls on multiples of a period goes by these. */
uint64_t bt_device_ticks(const struct bt_device *device);

/* From anywhere, a break interrupt of higher priority or another thread too: from now on the power stage is off. The
 * first code counts; 0 is none, and does nothing. */
void bt_device_trip(struct bt_device *device, uint16_t code);

/* Control interrupt: whether the inverter may switch in this tick; whether it is to brake to standstill; and that it
 * stands, or has turned back. */
bool bt_device_may_switch(const struct bt_device *device);
bool bt_device_is_quick_stopping(const struct bt_device *device);
void bt_device_standstill(struct bt_device *device);

/* Control interrupt: what the current sensors of the three outputs read, in A; see bt_currents.h. */
void bt_device_take_currents(struct bt_device *device, const float reading[3]);

/* Control interrupt: looks at the signals of this tick. */
void bt_device_tick(struct bt_device *device);

/* Control interrupt: whether bit 8 of the controlword halts the axis; and the setpoints that control is to follow in
 * this tick, which are 0 while it does and outside of Operation enabled. The commands themselves are kept. */
bool bt_device_is_halted(const struct bt_device *device);
float bt_device_torque_setpoint(const struct bt_device *device);
float bt_device_omega_m_setpoint(const struct bt_device *device);

/* Main loop: more of what a signal counts. */
void bt_device_count(uint32_t *counter, uint32_t more);

/* With the lock held, or in the control interrupt. */
uint16_t bt_device_statusword(const struct bt_device *device);

/* With the lock held: no target outlives what makes a fresh command necessary. */
void bt_device_zero_targets(struct bt_device *device);

/* ---- access, bt_objects.c ------------------------------------------------------------------------------- */

/* The value of an object as it was when it was read; a capture's bytes stay where they are. */
struct bt_value {
    size_t n;
    const char *text; /* of a string */
    bool is_capture;
    uint8_t number[4];
};

/* With the lock held, or in the control interrupt: the number of an entry, computed or from its variable. BT_OK or an
 * abort code. */
uint32_t bt_number(const struct bt_device *device, enum bt_id id, union bt_number *number);

/* BT_OK or an abort code; a refused write changes nothing. */
uint32_t bt_read(const struct bt_device *device, uint16_t index, uint8_t sub, struct bt_value *value);
uint32_t bt_write(struct bt_device *device, uint16_t index, uint8_t sub, const uint8_t *data, size_t n);

/* Whether an entry would take these bytes now; only storing and restoring may still fail. */
uint32_t bt_check(const struct bt_device *device, enum bt_id id, const uint8_t *data, size_t n);

/* n bytes of a value. */
void bt_value_copy(struct bt_device *device, const struct bt_value *value, size_t from, uint8_t *data, size_t n);

/* Both setpoints or neither; the control interrupt never sees one of them alone. */
uint32_t bt_take_setpoint(struct bt_device *device, const uint8_t torque[4], const uint8_t omega_m[4]);

/* Takes kept parameters before bt_device_reset puts them in force. False, and the defaults will be, if they are of
 * another dictionary or one is not what it may be, beside the others and within the sensors' ranges. */
bool bt_preset(struct bt_device *device, const uint32_t *raw, size_t n);

/* The string of an entry, that of the table unless the firmware gave its own. */
const char *bt_text(const struct bt_device *device, enum bt_id id);

/* CiA 301, 7.5.2.2: bit 0 with every error, and that of its class. */
uint8_t bt_error_register(uint16_t code);

#ifdef __cplusplus
}
#endif

#endif
