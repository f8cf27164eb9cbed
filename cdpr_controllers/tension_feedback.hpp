// Feedback of measured tensions: cdpr_controllers/tension_feedback.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct TensionFeedback {
    const double* gains;        // (3, m): gain; integral gain times the control step; limit of the integral, N
    const double* distributed;  // (m), N: wanted tensions at the platform
    const double* measured;     // (m), N
    const double* age;          // (1), s, of the measurement
    const double* limits;       // (2, m), N
    double* integral;           // (m), N
    double* logged;             // (m), N: the distributed tensions
    double* tension;            // (m), N: tensions to send
    double first;               // s: a measurement taken before it shows no tension
    int64_t m;
    static constexpr char fields[] =
        "gains(3, m), distributed(m), measured(m), age(1), limits(2, m), both integral(m), logged(m), tension(m), "
        "first, m";
};

// Write tensions within the limits, and advance the integrals. The integral of a cable does not grow while its tension
// is at the limit in that direction, and does not change for a locked cable, whose limits are equal.
inline int tension_feedback(TensionFeedback& p, double time) {
    const bool known = time - *p.age > p.first;
    for (int64_t i = 0; i < p.m; i++) {
        const double low = p.limits[i], high = p.limits[p.m + i], wanted = p.distributed[i];
        const double error = known ? wanted - p.measured[i] : 0.0, limit = p.gains[2 * p.m + i];
        const double grown = smaller(larger(p.integral[i] + p.gains[p.m + i] * error, -limit), limit);
        const double ahead = wanted + p.gains[i] * error, sum = ahead + grown;
        const bool saturated = (sum > high && error > 0.0) || (sum < low && error < 0.0);
        if (low < high && (!saturated || p.integral[i] * error < 0.0)) p.integral[i] = grown;
        p.logged[i] = wanted;
        p.tension[i] = smaller(larger(ahead + p.integral[i], low), high);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
