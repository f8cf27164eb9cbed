// Tensions of the control period that ends, with the hysteresis of load cells. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct LastTensions {
    const double* tension;  // (m), N, written after the last sample
    double* truth;          // (m), N
    const double* widths;   // (e), N, of the stop elements: each follows the tension within plus and minus its width
    double* stops;          // (m, e), N
    double* before;         // (m), N, tension at the control step before
    double share;           // of the sum of a cable's stops by which its measured tension lags
    int64_t m;
    int64_t e;
    static constexpr char fields[] = "tension(m), truth(m), widths(e), both stops(m, e), both before(m), share, m, e";
};

// Write the tensions; 0 at time 0, before which none acted. Hysteresis: Prandtl-Ishlinskii model of stop elements.
inline int last_tensions(LastTensions& p, double time) {
    const bool first = !(time > 0.0);
    for (int64_t i = 0; i < p.m; i++) {
        const double now = first ? 0.0 : p.tension[i];
        double lag = 0.0;
        for (int64_t j = 0; j < p.e; j++) {
            double& stop = p.stops[p.e * i + j];
            stop = first ? 0.0 : smaller(larger(stop + (now - p.before[i]), -p.widths[j]), p.widths[j]);
            lag += stop;
        }
        p.before[i] = now;
        p.truth[i] = p.e > 0 ? now - p.share * lag : now;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
