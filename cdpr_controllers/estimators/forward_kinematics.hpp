// State from successive poses: cdpr_controllers/estimators/forward_kinematics.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

struct PoseDifferences {
    const double* pose;   // (7), position, m, and quaternion
    const double* fits;   // (1), 1 if the pose is valid
    const double* fresh;  // (1), 1 if the pose is that of a new measurement
    const double* age;    // (1), s, time since it was taken
    const double* start;  // (13), state at time 0
    double* before;       // (8): the last pose, and the time at which it was measured, s
    double* estimate;     // (13)
    double filter_time;   // s, time constant of the velocities
    static constexpr char fields[] =
        "pose(7), fits(1), fresh(1), age(1), start(13), both before(8), both estimate(13), filter_time";
};

// Write the pose, and velocities from the difference of two poses through a first-order filter (backward Euler). The
// first velocities are those of the start.
inline int pose_differences(PoseDifferences& p, double time) {
    const bool first = !(time > 0.0);
    for (int i = 0; i < 13 && first; i++) p.estimate[i] = p.start[i];
    if (*p.fresh == 0.0 || *p.fits == 0.0) {
        for (int i = 0; i < 7 && first; i++) p.before[i] = p.start[i];
        if (first) p.before[7] = 0.0;
        return 0;
    }
    const double taken = time - *p.age, elapsed = taken - p.before[7];
    if (!first && elapsed > 0.0) {
        const double share = elapsed / (p.filter_time + elapsed);
        const Vector<double> turn = logarithm(multiply(quaternion(p.pose + 3), conjugate(quaternion(p.before + 3))));
        double rate[6];
        for (int i = 0; i < 3; i++) rate[i] = (p.pose[i] - p.before[i]) / elapsed;
        store((1.0 / elapsed) * turn, rate + 3);
        for (int i = 0; i < 6; i++) p.estimate[7 + i] += share * (rate[i] - p.estimate[7 + i]);
    }
    for (int i = 0; i < 7; i++) p.before[i] = p.estimate[i] = p.pose[i];
    p.before[7] = taken;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
