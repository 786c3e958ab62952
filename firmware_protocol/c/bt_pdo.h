/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The rules of the objects that map process data (CiA 301, 7.2.2): 0x1400 to 0x1BFF. */
#ifndef BT_PDO_H
#define BT_PDO_H

#include "bt_dictionary.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether such an object may take a value now; BT_OK for all other objects. */
uint32_t bt_pdo_check(const struct bt_variables *variables, enum bt_id id, uint32_t value);

#ifdef __cplusplus
}
#endif

#endif
