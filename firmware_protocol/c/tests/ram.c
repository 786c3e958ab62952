/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Never run: `make size` reads from it how much of a drive's RAM is whose. */
#include "benchtool.h"

extern char ram_variables[sizeof(struct bt_variables)];
extern char ram_capture[sizeof(struct bt_capture)];
extern char ram_stream[sizeof(struct bt_stream)];
extern char ram_line[sizeof(struct bt_server)];
extern char ram_rest[sizeof(struct bt_drive) - sizeof(struct bt_variables) - sizeof(struct bt_capture) -
                     sizeof(struct bt_stream) - sizeof(struct bt_server)];

char ram_variables[sizeof ram_variables];
char ram_capture[sizeof ram_capture];
char ram_stream[sizeof ram_stream];
char ram_line[sizeof ram_line];
char ram_rest[sizeof ram_rest];
