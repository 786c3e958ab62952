#include "bt_watchdog.h"

#include "bt_bytes.h"
#include "drive_objects.h"

void bt_watchdog_configure(struct bt_watchdog *watchdog, uint32_t host_heartbeat, uint32_t tick_period_ns)
{
    const uint64_t timeout_ns = (uint64_t)(host_heartbeat & 0xFFFFu) * 1000000u;
    const uint64_t ticks = (timeout_ns + tick_period_ns / 2u) / tick_period_ns;
    watchdog->state = BT_LINK_STATE_OFF;
    BT_BARRIER();
    watchdog->host_node = (uint8_t)(host_heartbeat >> 16 & 0x7Fu);
    watchdog->timeout_ticks = timeout_ns > 0 && ticks == 0 ? 1u : (uint32_t)ticks;
    bt_watchdog_rearm(watchdog);
}

void bt_watchdog_rearm(struct bt_watchdog *watchdog)
{
    const bool supervised = watchdog->host_node != 0 && watchdog->timeout_ticks > 0;
    watchdog->state = supervised ? BT_LINK_STATE_WAITING : BT_LINK_STATE_OFF;
    BT_BARRIER();
    watchdog->expired = false;
}

void bt_watchdog_feed(struct bt_watchdog *watchdog, uint32_t tick)
{
    if (watchdog->state == BT_LINK_STATE_WAITING || watchdog->state == BT_LINK_STATE_ALIVE) {
        watchdog->fed_tick = tick;
        BT_BARRIER();
        watchdog->state = BT_LINK_STATE_ALIVE;
    }
}

bool bt_watchdog_may_enable(const struct bt_watchdog *watchdog)
{
    return !watchdog->expired &&
           (watchdog->state == BT_LINK_STATE_OFF || watchdog->state == BT_LINK_STATE_ALIVE);
}

bool bt_watchdog_lose(struct bt_watchdog *watchdog)
{
    if (!watchdog->expired || watchdog->state != BT_LINK_STATE_ALIVE)
        return false;
    watchdog->state = BT_LINK_STATE_LOST;
    watchdog->losses++;
    return true;
}

void bt_watchdog_tick(struct bt_watchdog *watchdog, uint32_t tick)
{
    if (watchdog->state == BT_LINK_STATE_ALIVE && tick - watchdog->fed_tick >= watchdog->timeout_ticks)
        watchdog->expired = true;
}
