/* Little-endian numbers in bytes, and what orders memory between the control interrupt and the main loop. */
#ifndef BT_BYTES_H
#define BT_BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Between the write of data and that of the counter or flag that hands them over, and the same when reading.
 * On one core the compiler must not reorder; the fence also serves two cores. */
#ifndef BT_BARRIER
#define BT_BARRIER() __atomic_thread_fence(__ATOMIC_SEQ_CST)
#endif

/* Around the few stores that the control interrupt must see together. On a Cortex-M interrupts are masked, for
 * some ten cycles; elsewhere the firmware defines both, or calls bt_tick and bt_poll from one thread. */
#ifndef BT_LOCK
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
static inline uint32_t bt_lock_(void)
{
    uint32_t primask;
    __asm__ volatile("mrs %0, primask\n\tcpsid i" : "=r"(primask) : : "memory");
    return primask;
}

static inline void bt_unlock_(uint32_t primask)
{
    __asm__ volatile("msr primask, %0" : : "r"(primask) : "memory");
}
#define BT_LOCK() const uint32_t bt_primask_ = bt_lock_()
#define BT_UNLOCK() bt_unlock_(bt_primask_)
#else
#define BT_LOCK() BT_BARRIER()
#define BT_UNLOCK() BT_BARRIER()
#endif
#endif

static inline uint16_t bt_get_u16(const uint8_t *from)
{
    return (uint16_t)(from[0] | from[1] << 8);
}

static inline uint32_t bt_get_u32(const uint8_t *from)
{
    return (uint32_t)from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 | (uint32_t)from[3] << 24;
}

static inline void bt_put_u16(uint8_t *to, uint16_t value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
}

static inline void bt_put_u32(uint8_t *to, uint32_t value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
    to[2] = (uint8_t)(value >> 16);
    to[3] = (uint8_t)(value >> 24);
}

/* The bits of a float as a word, and back. */
static inline uint32_t bt_word_of(float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    return word;
}

static inline float bt_float_of(uint32_t word)
{
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
}

/* Whether a float is neither infinite nor no number. */
static inline int bt_is_finite(float value)
{
    return (bt_word_of(value) & 0x7F800000u) != 0x7F800000u;
}

#endif
