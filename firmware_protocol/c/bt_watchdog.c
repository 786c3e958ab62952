/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_watchdog.h"

#include "bt_sync.h"
#include "drive_objects.h"

/* Periods from the expiry until the torque has ended: the one under way, the one for which the stage is off, and the
 * end of its currents. The watchdog expires by so many before the time in which the torque is to end. */
#define BT_REACTION_TICKS 3u

/* Forgets a loss; the caller holds the lock. */
static void rearm(struct bt_watchdog *watchdog)
{
    const bool supervised = watchdog->host_node != 0 && watchdog->timeout_ticks > 0;
    watchdog->state = supervised ? BT_LINK_STATE_WAITING : BT_LINK_STATE_OFF;
    watchdog->expired = false;
}

void bt_watchdog_configure(struct bt_watchdog *watchdog, uint32_t host_heartbeat, uint32_t tick_period_ns)
{
    const uint64_t timeout_ns = (uint64_t)(host_heartbeat & 0xFFFFu) * 1000000u;
    const uint64_t ticks = (timeout_ns + tick_period_ns / 2u) / tick_period_ns;
    BT_LOCK();
    watchdog->host_node = (uint8_t)(host_heartbeat >> 16 & 0x7Fu);
    watchdog->timeout_ticks = timeout_ns == 0 ? 0u : ticks > BT_REACTION_TICKS ? (uint32_t)ticks - BT_REACTION_TICKS : 1u;
    rearm(watchdog);
    BT_UNLOCK();
}

void bt_watchdog_rearm(struct bt_watchdog *watchdog)
{
    BT_LOCK();
    rearm(watchdog);
    BT_UNLOCK();
}

void bt_watchdog_feed(struct bt_watchdog *watchdog, const volatile uint32_t *tick)
{
    BT_LOCK();
    if (watchdog->state == BT_LINK_STATE_WAITING || watchdog->state == BT_LINK_STATE_ALIVE) {
        watchdog->fed_tick = *tick;
        watchdog->state = BT_LINK_STATE_ALIVE;
    }
    BT_UNLOCK();
}

bool bt_watchdog_may_enable(const struct bt_watchdog *watchdog)
{
    bool may;
    BT_LOCK();
    may = !watchdog->expired && (watchdog->state == BT_LINK_STATE_OFF || watchdog->state == BT_LINK_STATE_ALIVE);
    BT_UNLOCK();
    return may;
}

bool bt_watchdog_lose(struct bt_watchdog *watchdog)
{
    bool lost;
    BT_LOCK();
    lost = watchdog->expired && watchdog->state == BT_LINK_STATE_ALIVE;
    if (lost) {
        watchdog->state = BT_LINK_STATE_LOST;
        watchdog->losses++;
    }
    BT_UNLOCK();
    return lost;
}

void bt_watchdog_settle(struct bt_watchdog *watchdog)
{
    BT_LOCK();
    watchdog->expired = false;
    BT_UNLOCK();
}

void bt_watchdog_tick(struct bt_watchdog *watchdog, uint32_t tick)
{
    if (watchdog->state == BT_LINK_STATE_ALIVE && tick - watchdog->fed_tick >= watchdog->timeout_ticks)
        watchdog->expired = true;
}
