// Misbehaviour of an FMU in a step, on demand: compiled with the plant's source and CDPR_FAULTS, by tests alone.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "instance.h"

namespace fmu {

enum { NONE, FAIL_DISCARD, FAIL_ERROR, FAIL_FATAL, GIVE_NAN, SEGFAULT, ABORT, EXIT, HANG, LOG_FOREVER, PRINT };

static Status nothing_is_known(Instance* instance, double time) {
    for (int i = 0; i < 3; i++) instance->model.field[POSITION][i] = NAN;
    *instance->model.field[TIME] = time;
    instance->stale = false;
    return OK;  // as if all were well
}

bool misbehaves(Instance* instance, double from, double duration, Status* status) {
    const int fault = from < *instance->model.field[FAULT_TIME] ? NONE : int(*instance->model.field[FAULT]);
    switch (fault) {
        case FAIL_DISCARD:
            *status = report(instance, DISCARD, "the step is discarded");
            break;
        case FAIL_ERROR:
            *status = report(instance, ERROR, "the winch is on fire");
            break;
        case FAIL_FATAL:
            *status = report(instance, FATAL, "nothing works any more");
            break;
        case GIVE_NAN:
            *status = nothing_is_known(instance, from + duration);
            break;
        case SEGFAULT:
            *static_cast<volatile int*>(nullptr) = 1;
            break;
        case ABORT:
            abort();
        case EXIT:
            exit(3);
        case HANG:
            for (volatile int i = 0;; i = 0) {
            }
        case LOG_FOREVER:
            for (int i = 0;; i++) report(instance, WARNING, "message %d", i);
        case PRINT:
            puts("an FMU that prints");
            fflush(stdout);
            return false;
        default:
            return false;
    }
    return true;
}

}  // namespace fmu
