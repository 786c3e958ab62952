/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Never run: `make size` reads from it how much RAM the CAN side takes. */
#include "bt_canopen.h"

extern char ram_sdo[sizeof(struct bt_sdo)];
extern char ram_tpdos[sizeof(struct bt_tpdos)];
extern char ram_rings[sizeof(struct bt_can) - sizeof(struct bt_sdo) - sizeof(struct bt_tpdos)];
extern char ram_all[sizeof(struct bt_can)];

char ram_sdo[sizeof ram_sdo];
char ram_tpdos[sizeof ram_tpdos];
char ram_rings[sizeof ram_rings];
char ram_all[sizeof ram_all];
