/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Supervision of the link: object 0x1016 sets it up, the host's heartbeat and taken setpoints feed it, nothing else.
 *
 * The main loop configures and feeds; time is watched in the control interrupt, so that a main loop that hangs
 * stops the motor as well. `expired` is set there and cleared here. */
#ifndef BT_WATCHDOG_H
#define BT_WATCHDOG_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A link that may be lost for longer is not watched. */
#define BT_LONGEST_TIMEOUT_MS 2000u

struct bt_watchdog {
    uint32_t timeout_ticks;
    uint32_t losses;
    volatile uint32_t fed_tick;
    uint8_t host_node;
    volatile uint8_t state; /* enum bt_link_state */
    volatile bool expired;  /* in the control interrupt, until the main loop has dealt with it */
};

/* Takes the value of host_heartbeat: node id in bits 16 to 22, timeout in ms in bits 0 to 15; either 0 is off. */
void bt_watchdog_configure(struct bt_watchdog *watchdog, uint32_t host_heartbeat, uint32_t tick_period_ns);

/* Forget a loss, and wait for the next feed. */
void bt_watchdog_rearm(struct bt_watchdog *watchdog);

/* The host was heard in the present tick, which is read where no other can come between. */
void bt_watchdog_feed(struct bt_watchdog *watchdog, const volatile uint32_t *tick);

/* Whether the power stage may be switched on: heard, or not supervised. */
bool bt_watchdog_may_enable(const struct bt_watchdog *watchdog);

/* The loss that the control interrupt found becomes the state; false if it found none. */
bool bt_watchdog_lose(struct bt_watchdog *watchdog);

/* The loss has been dealt with: the state of the drive is what stops the motor from here on. */
void bt_watchdog_settle(struct bt_watchdog *watchdog);

/* In the control interrupt. */
void bt_watchdog_tick(struct bt_watchdog *watchdog, uint32_t tick);

#ifdef __cplusplus
}
#endif

#endif
