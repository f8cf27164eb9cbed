// Sum of the external wrenches of events. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct ExternalLoads {
    // (k, 10): first sample; sample after the last; angle per sample and first angle of the sine that multiplies the
    // amplitude, rad (a quarter turn for a constant load); amplitude (6), N and N m
    const double* loads;
    const int64_t* sample;  // (1)
    double* external;       // (6), N and N m, about the platform's origin, world axes
    int64_t k;
    static constexpr char fields[] = "loads(k, 10), sample(1), external(6), k";
};

// Write the wrench of a sample; return 1 if an oscillating load changes it at the next one.
inline int external_loads(ExternalLoads& events) {
    const double sample = double(events.sample[0]);
    bool swinging = false;
    for (int j = 0; j < 6; j++) events.external[j] = 0.0;
    for (int64_t i = 0; i < events.k; i++) {
        const double* load = events.loads + 10 * i;
        if (!(load[0] <= sample && sample < load[1])) continue;
        swinging = swinging || load[2] > 0.0;
        const double part = sine(load[3] + (sample - load[0]) * load[2]);
        for (int j = 0; j < 6; j++) events.external[j] += part * load[4 + j];
    }
    return swinging;
}

}  // namespace cdpr::CDPR_TARGET
