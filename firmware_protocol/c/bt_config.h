/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Sizes of the library's buffers. Give others to the compiler, as -DBT_TX_BYTES=4096u. */
#ifndef BT_CONFIG_H
#define BT_CONFIG_H

/* Longest payload that the drive takes, at least 128. A stream of 16 scaled signals takes 135. */
#ifndef BT_MAX_REQUEST
#define BT_MAX_REQUEST 256u
#endif

/* Longest payload that the drive sends, 128 to 4096: what the line carries in 0.1 s. */
#ifndef BT_MAX_REPLY
#define BT_MAX_REPLY 1024u
#endif

/* Bytes that may arrive between two calls of bt_poll; a power of two. */
#ifndef BT_RX_BYTES
#define BT_RX_BYTES 512u
#endif

/* Bytes that wait for the line; a power of two. */
#ifndef BT_TX_BYTES
#define BT_TX_BYTES 4096u
#endif

/* Of these, what batches and chunks leave to everything else. */
#ifndef BT_TX_RESERVE
#define BT_TX_RESERVE 1100u
#endif

/* 32-bit words between the control interrupt and bt_poll; a record takes one word more than it has values. */
#ifndef BT_STREAM_WORDS
#define BT_STREAM_WORDS 1024u
#endif

/* 32-bit words of the longest capture: rows times channels. */
#ifndef BT_CAPTURE_WORDS
#define BT_CAPTURE_WORDS 4096u
#endif

#if BT_MAX_REQUEST < 128 || BT_MAX_REQUEST > 4096 || BT_MAX_REPLY < 128 || BT_MAX_REPLY > 4096
#error "payloads have 128 to 4096 bytes"
#endif
#if (BT_RX_BYTES & (BT_RX_BYTES - 1)) || (BT_TX_BYTES & (BT_TX_BYTES - 1))
#error "the rings of bytes must have a power of two"
#endif
#if BT_TX_BYTES - BT_TX_RESERVE < BT_MAX_REPLY + 4 + (BT_MAX_REPLY + 4) / 254 + 3
#error "the longest reply must fit the transmit buffer beside its reserve"
#endif
#if BT_STREAM_WORDS < 34
#error "at least two records of 16 values must fit the stream's buffer"
#endif

#endif
