/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A serial CAN adapter in front of a drive: lines of text from and to the host (LAWICEL's slcan), frames from and to
 * the drive. It has what a host needs: bit rate, open, close, version, serial number, flags, data frames. */
#ifndef SLCAN_H
#define SLCAN_H

#include "bt_canopen.h"

#define SLCAN_LONGEST_LINE 32u

struct slcan {
    struct bt_can *can;
    bool is_open;
    size_t n; /* of the line begun */
    char line[SLCAN_LONGEST_LINE];
};

/* Takes a byte of the host; the bytes of the answer, at most 8, that `answer` holds then. */
size_t slcan_take(struct slcan *slcan, uint8_t byte, uint8_t *answer);

/* The line of a frame; its bytes, at most SLCAN_LONGEST_LINE. */
size_t slcan_line(const struct bt_can_frame *frame, uint8_t *line);

#endif
