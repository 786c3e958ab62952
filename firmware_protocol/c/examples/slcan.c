/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "slcan.h"

#include <string.h>

#define REFUSED "\a"
#define OK "\r"

static const char digits[] = "0123456789ABCDEF";

/* The value of n hexadecimal digits, or -1. */
static int32_t hexadecimal(const char *text, size_t n)
{
    int32_t value = 0;
    while (n-- > 0) {
        const char digit = *text++;
        const int number = digit >= '0' && digit <= '9'   ? digit - '0'
                           : digit >= 'A' && digit <= 'F' ? digit - 'A' + 10
                           : digit >= 'a' && digit <= 'f' ? digit - 'a' + 10
                                                          : -1;
        if (number < 0)
            return -1;
        value = value * 16 + number;
    }
    return value;
}

/* A data frame with an 11-bit identifier: tIIILDD.. */
static const char *transmit(struct slcan *slcan)
{
    uint8_t data[8];
    const int32_t id = slcan->n >= 5 ? hexadecimal(slcan->line + 1, 3) : -1;
    const size_t n = (size_t)(slcan->line[4] - '0');
    size_t k;
    if (!slcan->is_open || id < 0 || id > 0x7FF || n > 8 || slcan->n != 5 + 2 * n)
        return REFUSED;
    for (k = 0; k < n; k++) {
        const int32_t byte = hexadecimal(slcan->line + 5 + 2 * k, 2);
        if (byte < 0)
            return REFUSED;
        data[k] = (uint8_t)byte;
    }
    return bt_can_receive(slcan->can, (uint16_t)id, data, n) ? "z\r" : REFUSED;
}

static const char *obey(struct slcan *slcan)
{
    const bool alone = slcan->n == 1;
    switch (slcan->n > 0 ? slcan->line[0] : '\0') {
    case 't':
        return transmit(slcan);
    case 'S':
        return !slcan->is_open && slcan->n == 2 && slcan->line[1] >= '0' && slcan->line[1] <= '8' ? OK : REFUSED;
    case 'O':
        if (!alone || slcan->is_open)
            return REFUSED;
        slcan->is_open = true;
        return OK;
    case 'C':
        if (!alone || !slcan->is_open)
            return REFUSED;
        slcan->is_open = false;
        return OK;
    case 'V':
        return alone ? "V1010\r" : REFUSED;
    case 'N':
        return alone ? "NBT01\r" : REFUSED;
    case 'F':
        return alone && slcan->is_open ? "F00\r" : REFUSED;
    default:
        return REFUSED;
    }
}

size_t slcan_take(struct slcan *slcan, uint8_t byte, uint8_t *answer)
{
    const char *text;
    size_t n;
    if (byte != '\r') {
        if (slcan->n < sizeof slcan->line)
            slcan->line[slcan->n++] = (char)byte;
        return 0;
    }
    text = slcan->n < sizeof slcan->line ? obey(slcan) : REFUSED;
    slcan->n = 0;
    n = strlen(text);
    memcpy(answer, text, n);
    return n;
}

size_t slcan_line(const struct bt_can_frame *frame, uint8_t *line)
{
    size_t n = 0, k;
    line[n++] = 't';
    line[n++] = (uint8_t)digits[frame->id >> 8 & 7u];
    line[n++] = (uint8_t)digits[frame->id >> 4 & 15u];
    line[n++] = (uint8_t)digits[frame->id & 15u];
    line[n++] = (uint8_t)digits[frame->n];
    for (k = 0; k < frame->n; k++) {
        line[n++] = (uint8_t)digits[frame->data[k] >> 4];
        line[n++] = (uint8_t)digits[frame->data[k] & 15u];
    }
    line[n++] = '\r';
    return n;
}
