/* SPDX-License-Identifier: Apache-2.0 */
#define _POSIX_C_SOURCE 200809L
#include "cycle.h"

#include <time.h>

enum { SECOND = 1000000000 }; /* ns */

static int64_t now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * SECOND + time.tv_nsec;
}

void cycle_begin(cycle *begun, double period, int waits) {
    *begun = (cycle){.period = (int64_t)(period * SECOND + 0.5), .next = now(), .waits = waits};
}

void cycle_wait(cycle *waiting) {
    const struct timespec next = {waiting->next / SECOND, waiting->next % SECOND};
    while (waiting->waits && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL) != 0) continue;
    waiting->next += waiting->period;
    waiting->started = now();
}

void cycle_end(cycle *ended) {
    const int64_t taken = now() - ended->started;
    if (taken > ended->longest) ended->longest = taken;
    if (taken > ended->period) ended->overruns++;
}
