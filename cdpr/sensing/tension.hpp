// Tensions of the control period that ends. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

struct LastTensions {
    const double* tension;  // (m), N, written after the last sample
    double* truth;          // (m), N
    int64_t m;
    static constexpr char fields[] = "tension(m), truth(m), m";
};

// Write the tensions; 0 at time 0, before which none acted.
inline int last_tensions(LastTensions& p, double time) {
    for (int64_t i = 0; i < p.m; i++) p.truth[i] = time > 0.0 ? p.tension[i] : 0.0;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
