/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#define _XOPEN_SOURCE 700
#include "terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <time.h>

int terminal_open(const char **path)
{
    const int line = posix_openpt(O_RDWR | O_NOCTTY);
    struct termios raw;
    int other = -1;
    if (line >= 0 && grantpt(line) == 0 && unlockpt(line) == 0 && (*path = ptsname(line)) != NULL)
        other = open(*path, O_RDWR | O_NOCTTY);
    if (other < 0 || tcgetattr(other, &raw) != 0) {
        perror("pseudo-terminal");
        exit(1);
    }
    raw.c_iflag = 0;
    raw.c_oflag = 0;
    raw.c_lflag = 0;
    raw.c_cflag = CS8 | CREAD | CLOCAL;
    if (tcsetattr(other, TCSANOW, &raw) != 0 || fcntl(line, F_SETFL, O_NONBLOCK) != 0) {
        perror(*path);
        exit(1);
    }
    return line;
}

int64_t clock_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

void clock_wait_until(int64_t then_ns)
{
    struct timespec then;
    then.tv_sec = (time_t)(then_ns / 1000000000);
    then.tv_nsec = (long)(then_ns % 1000000000);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &then, NULL) == EINTR) {
    }
}
