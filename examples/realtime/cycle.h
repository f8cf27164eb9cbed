/* Periodic cycle on the monotonic clock. SPDX-License-Identifier: Apache-2.0 */
#ifndef CYCLE_H
#define CYCLE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int64_t period, next; /* ns */
    int64_t started;      /* ns, of the work in this cycle */
    int64_t longest;      /* ns, of work in a cycle */
    int64_t overruns;     /* cycles whose work took longer than the period */
    int waits;            /* 0: run as fast as possible */
} cycle;

/* Begin cycles of a period, s. */
void cycle_begin(cycle* begun, double period, int waits);

/* Wait until the next cycle begins. */
void cycle_wait(cycle* waiting);

/* Record that the work of this cycle is done. */
void cycle_end(cycle* ended);

/* Return the number of allocations of this program so far; -1 if they are not counted. */
long allocations(void);

#ifdef __cplusplus
}
#endif
#endif
