/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* A drive on a PC: it speaks the protocol on a pseudo-terminal or a TCP port, and turns a toy motor.
 *
 *     posix_drive [--rate HZ] [--tcp PORT] [--tick TICK]
 *
 * prints the link that the host is to be given; its first tick is 0 unless it is told otherwise. One loop stands for control interrupt, line and main loop: it runs
 * the ticks that are due, moves bytes, and sleeps for a millisecond. */
#define _XOPEN_SOURCE 700
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "benchtool.h"
#include "toy_motor.h"

#define TIME_STEP_NS 1000000
#define MOST_TICKS_BEHIND 1000

static struct bt_drive drive;

/* ---- the line ------------------------------------------------------------------------------------------- */

static void fail(const char *what)
{
    perror(what);
    exit(1);
}

static void no_wait(int file)
{
    if (fcntl(file, F_SETFL, O_NONBLOCK) != 0)
        fail("O_NONBLOCK");
}

/* The other end is kept open here, so that the line outlives its hosts. */
static int open_terminal(void)
{
    const int line = posix_openpt(O_RDWR | O_NOCTTY);
    const char *path;
    struct termios raw;
    int other;
    if (line < 0 || grantpt(line) != 0 || unlockpt(line) != 0 || (path = ptsname(line)) == NULL)
        fail("pseudo-terminal");
    other = open(path, O_RDWR | O_NOCTTY);
    if (other < 0 || tcgetattr(other, &raw) != 0)
        fail(path);
    raw.c_iflag = 0;
    raw.c_oflag = 0;
    raw.c_lflag = 0;
    raw.c_cflag = CS8 | CREAD | CLOCAL;
    if (tcsetattr(other, TCSANOW, &raw) != 0)
        fail(path);
    no_wait(line);
    printf("serial:%s\n", path);
    return line;
}

static int listen_on(uint16_t port)
{
    const int socket_ = socket(AF_INET, SOCK_STREAM, 0), yes = 1;
    struct sockaddr_in address = { 0 };
    socklen_t n = sizeof address;
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    if (socket_ < 0 || setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(socket_, (const struct sockaddr *)&address, n) != 0 || listen(socket_, 1) != 0 ||
        getsockname(socket_, (struct sockaddr *)&address, &n) != 0)
        fail("listening");
    no_wait(socket_);
    printf("serial:socket://127.0.0.1:%u\n", (unsigned)ntohs(address.sin_port));
    return socket_;
}

/* One host at a time; what is for one that has left is dropped. The line, -1 without a host. */
static int serve(int listener, int line)
{
    uint8_t data[4096];
    ssize_t n;
    if (line < 0 && listener >= 0 && (line = accept(listener, NULL, NULL)) >= 0)
        no_wait(line);
    if (line < 0) {
        while (bt_transmit(&drive, data, sizeof data) > 0) {
        }
        return line;
    }
    while ((n = read(line, data, sizeof data)) > 0)
        bt_receive(&drive, data, (size_t)n);
    if (listener >= 0 && (n == 0 || (n < 0 && errno != EAGAIN))) {
        close(line);
        return -1;
    }
    return line;
}

/* Bytes that the line did not take wait in `held`, as they are out of the drive's buffer. */
static void send_on(int line)
{
    static uint8_t held[4096];
    static size_t from, to;
    while (line >= 0) {
        ssize_t n;
        if (from == to) {
            from = 0;
            to = bt_transmit(&drive, held, sizeof held);
        }
        if (from == to || (n = write(line, held + from, to - from)) < 0)
            return;
        from += (size_t)n;
    }
    from = to;
}

/* ---- time ----------------------------------------------------------------------------------------------- */

static int64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static void wait_until(int64_t then_ns)
{
    struct timespec then;
    then.tv_sec = (time_t)(then_ns / 1000000000);
    then.tv_nsec = (long)(then_ns % 1000000000);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &then, NULL) == EINTR) {
    }
}

int main(int count, char **arguments)
{
    struct bt_config config = { 0 };
    int listener = -1, line = -1, k;
    long rate_Hz = 1000, port = -1;
    unsigned long tick = 0;
    int64_t due_ns, step_ns;
    for (k = 1; k + 1 < count; k += 2) {
        if (strcmp(arguments[k], "--rate") == 0)
            rate_Hz = strtol(arguments[k + 1], NULL, 10);
        else if (strcmp(arguments[k], "--tcp") == 0)
            port = strtol(arguments[k + 1], NULL, 10);
        else if (strcmp(arguments[k], "--tick") == 0)
            tick = strtoul(arguments[k + 1], NULL, 10);
        else
            break;
    }
    if (k != count || rate_Hz < 10 || rate_Hz > 20000 || port > 65535) {
        fprintf(stderr, "posix_drive [--rate 10..20000] [--tcp PORT] [--tick TICK]\n");
        return 2;
    }
    signal(SIGPIPE, SIG_IGN);
    config.tick_period_ns = (uint32_t)(1000000000 / rate_Hz);
    config.node_id = 1;
    config.serial_number = 1;
    config.first_tick = (uint32_t)tick;
    config.i_full_scale = 20.0f;
    config.u_dc_full_scale = 500.0f;
    config.hardware_version = "posix";
    bt_init(&drive, &config);
    if (port >= 0)
        listener = listen_on((uint16_t)port);
    else
        line = open_terminal();
    fflush(stdout);
    step_ns = (int64_t)config.tick_period_ns;
    for (due_ns = now_ns();;) {
        const int64_t end_ns = now_ns();
        if (end_ns - due_ns > MOST_TICKS_BEHIND * step_ns)
            due_ns = end_ns; /* stopped or starved for long: time that was lost is not made up for */
        for (; due_ns <= end_ns; due_ns += step_ns)
            toy_motor_tick(&drive);
        line = serve(listener, line);
        bt_poll(&drive);
        send_on(line);
        wait_until(end_ns + (step_ns > TIME_STEP_NS ? step_ns : TIME_STEP_NS));
    }
}
