// Lengths that drums have paid out. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

struct PaidOut {
    const double* unwound;    // (m), m, of winches; NaN without one
    const double* unwinding;  // (m), m/s, its rate
    const double* length;     // (m), m, of cables
    const double* rate;       // (m), m/s
    double* truth;            // (2, m)
    int64_t m;
    static constexpr char fields[] = "unwound(m), unwinding(m), length(m), rate(m), truth(2, m), m";
};

// Write the lengths that winches have paid out, and their rates; those of the cable without a winch, and at time 0,
// when the tensions that stretch the cables are not yet known.
inline int paid_out(PaidOut& p, double time) {
    for (int64_t i = 0; i < p.m; i++) {
        const bool known = time > 0.0 && p.unwound[i] == p.unwound[i];
        p.truth[i] = known ? p.unwound[i] : p.length[i];
        p.truth[p.m + i] = known ? p.unwinding[i] : p.rate[i];
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
