/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* The lock of a firmware that has threads: given to all sources with -include. */
#ifndef PTHREAD_LOCK_H
#define PTHREAD_LOCK_H

#include <pthread.h>

/* Both end the program on any error: a lock taken twice, or given back by another thread. */
void pthread_lock_take(void);
void pthread_lock_give(void);

#define BT_LOCK() pthread_lock_take()
#define BT_UNLOCK() pthread_lock_give()

#endif
