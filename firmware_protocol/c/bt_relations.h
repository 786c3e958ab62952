/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Limits that are another entry's value: a trip level is at most what the converter reaches. A limit of 0 is not
 * known, and none. */
#ifndef BT_RELATIONS_H
#define BT_RELATIONS_H

#include "bt_dictionary.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether an entry may have this number beside the others: BT_OK; BT_ABORT_VALUE_HIGH or BT_ABORT_VALUE_LOW if it is
 * beyond one, BT_ABORT_PARAMETER_INCOMPATIBLE if it would leave another beyond it. The parameters are those in
 * `parameters`, all of them in the order of the table, or the variables if that is NULL. */
uint32_t bt_check_relations(const struct bt_variables *variables, const uint32_t *parameters, enum bt_id id,
                            union bt_number number);

/* With the lock held: no variable is above the entry that limits it. */
void bt_cut_to_relations(struct bt_variables *variables);

#ifdef __cplusplus
}
#endif

#endif
