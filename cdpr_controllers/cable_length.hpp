// Control of each cable's length and rate: cdpr_controllers/cable_length.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/checks.hpp>
#include <cdpr/field.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

struct CableLengthControl {
    const double* gains;     // (4, m): kp, N/m; kd, N s/m; ki times the control step, N/m; limit of the integral, N
    const double* limits;    // (2, m), N
    const double* measured;  // (2, m): lengths, m, and rates, m/s
    const double* desired;   // (2, m): the same
    const double* feed;      // (m), N: tensions that hold the platform up
    double* integral;        // (m), N
    double* command;         // (m), N
    int64_t m;
    static constexpr Field fields[] = {
        in("gains", "4", "m"), in("limits", "2", "m"), in("measured", "2", "m"), in("desired", "2", "m"),
        in("feed", "m"),       both("integral", "m"),  out("command", "m"),      size("m")};
};

// Write the commands and advance the integrals. An integral does not grow while its cable is at the limit of tension
// that it pushes against.
inline int cable_length(CableLengthControl& p) {
    const int64_t m = p.m;
    for (int64_t i = 0; i < m; i++) {
        const double kp = p.gains[i], kd = p.gains[m + i], limit = p.gains[3 * m + i];
        const double error = p.measured[i] - p.desired[i], change = p.gains[2 * m + i] * error;
        const double grown = smaller(larger(p.integral[i] + change, -limit), limit);
        const double t = p.feed[i] + kp * error + kd * (p.measured[m + i] - p.desired[m + i]);
        const bool pushes_up = t + grown > p.limits[m + i] - LIMIT_TOLERANCE && change > 0.0;
        const bool pushes_down = t + grown < p.limits[i] + LIMIT_TOLERANCE && change < 0.0;
        if (!(pushes_up || pushes_down) || p.integral[i] * change < 0.0) p.integral[i] = grown;
        p.command[i] = t + p.integral[i];
    }
    return 0;
}

}  // namespace CDPR_TARGET
}  // namespace cdpr
