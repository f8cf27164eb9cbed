/* How an FMU can misbehave in a step: compiled with the plant's source and CDPR_FAULTS, by tests alone. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "instance.h"

enum { NONE, FAIL_DISCARD, FAIL_ERROR, FAIL_FATAL, GIVE_NAN, SEGFAULT, ABORT, EXIT, HANG, LOG_FOREVER, PRINT };

Status fault(Instance *instance, double time) {
    if (time < *instance->plant.field[FAULT_TIME]) return OK;
    switch ((int)*instance->plant.field[FAULT]) {
    case FAIL_DISCARD: return report(instance, DISCARD, "the step is discarded");
    case FAIL_ERROR: return report(instance, ERROR, "the winch is on fire");
    case FAIL_FATAL: return report(instance, FATAL, "nothing works any more");
    case GIVE_NAN:
        instance->plant.state[0] = NAN;
        plant_advance(&instance->plant, *instance->plant.field[PHYSICS_STEP]);
        *instance->plant.field[TIME] += *instance->plant.field[PHYSICS_STEP];
        instance->plant.state[0] = 0.0;
        return WARNING; /* the caller returns at once, and hosts go on after a warning */
    case SEGFAULT: *(volatile int *)0 = 1; break;
    case ABORT: abort();
    case EXIT: exit(3);
    case HANG:
        for (volatile int i = 0;; i = 0) {}
    case LOG_FOREVER:
        for (int i = 0;; i++) report(instance, WARNING, "message %d", i);
    case PRINT:
        puts("an FMU that prints");
        fflush(stdout);
        break;
    default: break;
    }
    return OK;
}
