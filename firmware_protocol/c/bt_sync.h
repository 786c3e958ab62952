/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* What lets interrupts or threads share a drive: a lock, counters that hand over, a number that is set once.
 *
 * Each may be defined by the firmware, for all sources alike: -include my_lock.h, or -D of both macros of a pair. */
#ifndef BT_SYNC_H
#define BT_SYNC_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
static inline uint32_t bt_mask_interrupts(void)
{
    uint32_t primask;
    __asm__ volatile("mrs %0, primask\n\tcpsid i" : "=r"(primask) : : "memory");
    return primask;
}

static inline void bt_restore_interrupts(uint32_t primask)
{
    __asm__ volatile("msr primask, %0" : : "r"(primask) : "memory");
}
#define BT_IS_CORTEX_M 1
#endif

/* Around the main loop's accesses to what the control interrupt shares. It is never taken twice, and nowhere held for
 * longer than some hundred cycles. The functions of the control interrupt do not take it: on one core that interrupt
 * cannot be interrupted by the main loop, and a thread in its place holds the lock for the whole of its tick. */
#if defined(BT_LOCK) != defined(BT_UNLOCK)
#error "define BT_LOCK and BT_UNLOCK, or neither"
#elif defined(BT_LOCK)
/* the firmware's own */
#elif defined(BT_ONE_THREAD) /* one thread calls all functions of the library */
#define BT_LOCK() ((void)0)
#define BT_UNLOCK() ((void)0)
#elif defined(BT_IS_CORTEX_M)
#define BT_LOCK() const uint32_t bt_primask_ = bt_mask_interrupts()
#define BT_UNLOCK() bt_restore_interrupts(bt_primask_)
#else
#error "not a Cortex-M: define BT_LOCK() and BT_UNLOCK(), or BT_ONE_THREAD if one thread calls all of the library"
#endif

/* A counter or flag that hands over what was written before it, to an interrupt or thread that takes no lock. */
#if defined(BT_LOAD) != defined(BT_STORE)
#error "define BT_LOAD and BT_STORE, or neither"
#elif !defined(BT_LOAD)
#if !defined(__GNUC__)
#error "not a GNU compiler: define BT_LOAD(at) and BT_STORE(at, value), with acquire and release order"
#endif
#define BT_LOAD(at) __atomic_load_n((at), __ATOMIC_ACQUIRE)
#define BT_STORE(at, value) __atomic_store_n((at), (value), __ATOMIC_RELEASE)
#endif

/* Sets a number that is 0, as one step whatever interrupts it; whether it was 0. */
static inline bool bt_set_once(volatile uint16_t *at, uint16_t value)
{
#if defined(BT_SET_ONCE)
    return BT_SET_ONCE(at, value);
#elif defined(__GCC_HAVE_SYNC_COMPARE_AND_SWAP_2)
    uint16_t zero = 0;
    return __atomic_compare_exchange_n(at, &zero, value, false, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE);
#elif defined(BT_IS_CORTEX_M)
    const uint32_t primask = bt_mask_interrupts();
    const bool was_zero = *at == 0;
    if (was_zero)
        *at = value;
    bt_restore_interrupts(primask);
    return was_zero;
#else
#error "no compare-and-swap of 16 bits here: define BT_SET_ONCE(at, value)"
#endif
}

#ifdef __cplusplus
}
#endif

#endif
