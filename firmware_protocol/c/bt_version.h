/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The library's version, that of the benchtool it came with. The wire has its own: BT_PROTOCOL_VERSION and
 * BT_DICTIONARY_HASH. */
#ifndef BT_VERSION_H
#define BT_VERSION_H

#define BT_VERSION_MAJOR 0
#define BT_VERSION_MINOR 1
#define BT_VERSION_PATCH 0
#define BT_VERSION_STRING "0.1.0"

/* One number, to be compared: #if BT_VERSION >= BT_VERSION_NUMBER(0, 2, 0) */
#define BT_VERSION_NUMBER(major, minor, patch) ((major) * 10000 + (minor) * 100 + (patch))
#define BT_VERSION BT_VERSION_NUMBER(BT_VERSION_MAJOR, BT_VERSION_MINOR, BT_VERSION_PATCH)

#endif
