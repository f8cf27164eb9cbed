// Calls of an exported pipeline, written by Python (cdpr/native/exported_pipeline.py).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stddef.h>

#include <cdpr/table.h>
#include <cdpr/target.hpp>

namespace cdpr::CDPR_TARGET {

// Meaning of a status other than 0: none; the operation found no answer; a value is not finite; no estimate.
enum Vital { IGNORED, ANSWER, FINITE, ESTIMATE };

// Call of a compiled operation.
struct Call {
    cdpr_operation operation;
    void* place;    // its struct
    bool in_order;  // whether it is called in each control step; others only when needed
    Vital vital;
    size_t skip;  // number of calls to skip then
    int repair;   // index of the call to make then, with the status in place of the time; -1 for none
};

// Make the calls of one control step at a time [s]; return the call that failed without repair, nullptr if all
// succeeded.
CDPR_INLINE const Call* make_calls(const Call* calls, size_t count, double time) {
    for (size_t k = 0; k < count; k++) {
        const Call& call = calls[k];
        if (!call.in_order) continue;
        const int status = call.operation(call.place, time);
        if (status == 0 || call.vital == IGNORED) continue;
        if (call.repair < 0) return &call;
        const Call& repair = calls[call.repair];
        if (repair.operation(repair.place, double(status)) != 0) return &call;
        k += call.skip;
    }
    return nullptr;
}

}  // namespace cdpr::CDPR_TARGET
