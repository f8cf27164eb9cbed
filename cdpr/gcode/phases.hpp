// Phases of constant jerk along a path. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// Distance, m, of a change between two speeds, m/s, without acceleration at both; 0 if the speed does not rise.
CDPR_INLINE double ramp_way(double slow, double fast, double acceleration, double jerk) {
    const double change = fast - slow;
    if (change <= 0.0) return 0.0;
    const bool steady = change * jerk >= acceleration * acceleration;
    const double time = steady ? change / acceleration + acceleration / jerk : 2.0 * square_root(change / jerk);
    return 0.5 * (slow + fast) * time;
}

// Table of phases: duration, s; position on the path, m; speed, m/s, acceleration, m/s^2, at its beginning; jerk,
// m/s^3.
struct Phases {
    static constexpr int PHASE = 5, TIME = 0, PLACE = 1, SPEED = 2, ALONG = 3, JERK = 4;

    double* rows;
    int64_t count;

    inline void add(double time, double s, double v, double a, double jerk);
    inline void add_ramp(double s, double begin, double end, double acceleration, double jerk);
};

// Append a phase, or extend the last one at the same speed.
inline void Phases::add(double time, double s, double v, double a, double jerk) {
    if (time <= 0.0) return;
    double* phase = rows + count * PHASE;
    if (count > 0 && jerk == 0.0 && a == 0.0) {
        double* before = phase - PHASE;
        const bool cruises = before[JERK] == 0.0 && before[ALONG] == 0.0;
        if (cruises && before[SPEED] == v && v > 0.0 && s > before[PLACE]) {  // and in the same chain
            before[TIME] = (s - before[PLACE]) / v + time;
            return;
        }
    }
    phase[TIME] = time;
    phase[PLACE] = s;
    phase[SPEED] = v;
    phase[ALONG] = a;
    phase[JERK] = jerk;
    count++;
}

// Append a change of speed from `begin` to `end`, m/s, at s.
inline void Phases::add_ramp(double s, double begin, double end, double acceleration, double jerk) {
    const double change = absolute(end - begin), sign = end > begin ? 1.0 : -1.0;
    if (change == 0.0) return;
    double steady = 0.0, rise = 0.0;
    if (change * jerk >= acceleration * acceleration) {
        rise = acceleration / jerk;
        steady = larger(change / acceleration - rise, 0.0);
    } else {
        rise = square_root(change / jerk);
    }
    const double a = sign * jerk * rise, j = sign * jerk;
    double v = begin;
    add(rise, s, v, 0.0, j);
    s += rise * (v + j * rise * rise / 6.0);
    v += 0.5 * a * rise;
    add(steady, s, v, a, 0.0);
    s += steady * (v + 0.5 * a * steady);
    v += a * steady;
    add(rise, s, v, a, -j);
}

}  // namespace cdpr::CDPR_TARGET
