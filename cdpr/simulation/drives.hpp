// Drives that apply the commands of winches imperfectly. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/parts.hpp>
#include <cdpr/field.hpp>
#include <cdpr/random_numbers.hpp>

namespace cdpr::CDPR_TARGET {

struct ImperfectDrives {
    const double* command;       // (m), N, m or m/s, of the winches
    const double* imposed;       // (m), N, tensions that events impose on cables; NaN for none
    const int64_t* takes;        // (m), a CommandKind
    const double* imperfection;  // (m, 4): delay in control periods, resolution, largest change in a period, half play
    double* line;                // (k, m), sent commands, the present one first; k is longer than every delay
    double* motor;               // (m), command after the limit of its rate
    double* drum;                // (m), command after the play; of a rate: position of the motor in the play, m
    double* applied;             // (m), N, m or m/s
    double period;               // s, of control
    int64_t m;
    int64_t k;
    static constexpr char fields[] =
        "command(m), imposed(m), takes(m), imperfection(m, 4), both line(k, m), both motor(m), "
        "both drum(m), applied(m), period, m, k >= 1";
};

// Write the commands that the drives apply: rounded, late, limited in their rate, and with play. At time 0 the memory
// is that of drives at rest: they have had the present tension or length, or the rate 0, for ever.
inline int apply_drives(ImperfectDrives& p, double time) {
    const bool first = !(time > 0.0);
    for (int64_t j = p.k * p.m - 1; j >= p.m; j--) p.line[j] = p.line[j - p.m];
    for (int64_t i = 0; i < p.m; i++) {
        const double* const own = p.imperfection + 4 * i;
        const double resolution = own[1], most = own[2], half = own[3];
        const bool rate = p.takes[i] == RATE_COMMAND;
        const double given = resolution > 0.0 ? nearest_multiple(p.command[i], resolution) : p.command[i];
        if (first) {
            const double before = rate ? 0.0 : given;
            for (int64_t j = 0; j < p.k; j++) p.line[j * p.m + i] = before;
            p.motor[i] = p.drum[i] = before;
        }
        p.line[i] = given;
        const double sent = p.line[int64_t(own[0]) * p.m + i];
        const double motor = p.motor[i] = smaller(larger(sent, p.motor[i] - most), p.motor[i] + most);
        if (!(half > 0.0)) {
            p.applied[i] = motor;
        } else if (rate) {
            const double moved = p.drum[i] + p.period * motor;
            p.drum[i] = smaller(larger(moved, -half), half);
            p.applied[i] = (moved - p.drum[i]) / p.period;
        } else {
            p.applied[i] = p.drum[i] = smaller(larger(p.drum[i], motor - half), motor + half);
        }
        if (p.takes[i] == TENSION_COMMAND && p.imposed[i] == p.imposed[i]) p.applied[i] = p.imposed[i];
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
