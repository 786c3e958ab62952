/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* CRC-32 of IEEE 802.3, as zlib's. */
#ifndef BT_CRC_H
#define BT_CRC_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* CRC of data that continue those of `crc`; 0 to begin. */
uint32_t bt_crc(uint32_t crc, const uint8_t *data, size_t n);

#ifdef __cplusplus
}
#endif

#endif
