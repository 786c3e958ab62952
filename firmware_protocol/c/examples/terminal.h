/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A pseudo-terminal in place of an adapter's device file, and the clock, on a POSIX system. */
#ifndef TERMINAL_H
#define TERMINAL_H

#include <stdint.h>

/* The drive's end, raw and without waiting; `path` is where hosts find theirs. The program ends if there is none.
 * The hosts' end is kept open as well, so that the line outlives them. */
int terminal_open(const char **path);

int64_t clock_now_ns(void);
void clock_wait_until(int64_t then_ns);

#endif
