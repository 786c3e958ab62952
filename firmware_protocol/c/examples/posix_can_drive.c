/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A drive on a CAN bus on a PC: behind a serial CAN adapter (slcan) on a pseudo-terminal, with a toy motor.
 *
 *     posix_can_drive [--rate HZ] [--tick TICK]
 *
 * prints the link that the host is to be given; its first tick is 0 unless it is told otherwise. One loop stands for control interrupt, bus and main loop: it runs
 * the ticks that are due, moves frames, and sleeps for a millisecond. */
#define _XOPEN_SOURCE 700
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "benchtool.h"
#include "bt_canopen.h"
#include "slcan.h"
#include "terminal.h"
#include "toy_motor.h"

#define TIME_STEP_NS 1000000
#define MOST_TICKS_BEHIND 1000

static struct bt_drive drive; /* its serial line leads nowhere */
static struct bt_can can;
static struct slcan adapter;

/* Bytes that the host has not taken yet. Without room, frames stay in the drive's rings, and are lost there. */
static uint8_t held[65536];
static size_t from, to;

static void send_on(int line)
{
    ssize_t n;
    while (from < to && (n = write(line, held + from, to - from)) > 0)
        from += (size_t)n;
    if (from == to)
        from = to = 0;
}

static void receive(int line)
{
    uint8_t data[4096];
    ssize_t n, k;
    while ((n = read(line, data, sizeof data)) > 0) {
        for (k = 0; k < n; k++) {
            uint8_t answer[8];
            const size_t length = slcan_take(&adapter, data[k], answer);
            if (length > 0 && sizeof held - to >= length) {
                memcpy(held + to, answer, length);
                to += length;
            }
            if (length > 0)
                bt_can_poll(&can); /* a frame may have come */
        }
    }
}

static void transmit(void)
{
    struct bt_can_frame frame;
    while (sizeof held - to >= SLCAN_LONGEST_LINE && bt_can_transmit(&can, &frame)) {
        if (adapter.is_open)
            to += slcan_line(&frame, held + to);
        bt_can_poll(&can); /* segments that waited for room */
    }
}

int main(int count, char **arguments)
{
    struct bt_config config = { 0 };
    const char *path;
    long rate_Hz = 1000;
    unsigned long tick = 0;
    int k;
    int64_t due_ns, step_ns;
    int line;
    for (k = 1; k + 1 < count; k += 2) {
        if (strcmp(arguments[k], "--rate") == 0)
            rate_Hz = strtol(arguments[k + 1], NULL, 10);
        else if (strcmp(arguments[k], "--tick") == 0)
            tick = strtoul(arguments[k + 1], NULL, 10);
        else
            break;
    }
    if (k != count || rate_Hz < 10 || rate_Hz > 20000) {
        fprintf(stderr, "posix_can_drive [--rate 10..20000] [--tick TICK]\n");
        return 2;
    }
    step_ns = 1000000000 / rate_Hz;
    config.tick_period_ns = (uint32_t)step_ns;
    config.node_id = 1;
    config.serial_number = 1;
    config.first_tick = (uint32_t)tick;
    config.i_full_scale = 20.0f;
    config.u_dc_full_scale = 500.0f;
    config.hardware_version = "posix";
    bt_init(&drive, &config);
    bt_can_init(&can, &drive.node);
    adapter.can = &can;
    line = terminal_open(&path);
    printf("can:slcan:%s\n", path);
    fflush(stdout);
    for (due_ns = clock_now_ns();;) {
        const int64_t end_ns = clock_now_ns();
        if (end_ns - due_ns > MOST_TICKS_BEHIND * step_ns)
            due_ns = end_ns; /* stopped or starved for long: time that was lost is not made up for */
        for (; due_ns <= end_ns; due_ns += step_ns) {
            toy_motor_tick(&drive);
            bt_can_tick(&can);
        }
        bt_poll(&drive);
        receive(line);
        bt_can_poll(&can);
        transmit();
        send_on(line);
        clock_wait_until(end_ns + (step_ns > TIME_STEP_NS ? step_ns : TIME_STEP_NS));
    }
}
