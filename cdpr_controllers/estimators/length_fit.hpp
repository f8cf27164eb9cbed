// Pose from measured cable lengths at each arrival: cdpr_controllers/estimators/length_fit.py.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/forward_kinematics.hpp>

namespace cdpr::CDPR_TARGET {

struct LengthFit {
    ForwardKinematics fit;  // `target` contains the measured lengths, `pose` the last fit
    const double* fresh;    // (1), 1 if new lengths have arrived
    const double* start;    // (13), state at time 0
    double* fits;           // (1), 1 if the last lengths that arrived were fitted
    static constexpr auto fields = extended(ForwardKinematics::fields, "fresh(1), start(13), both fits(1)");
};

// Fit the pose to lengths that have arrived, from the last fit; without convergence, keep it. At time 0, begin anew.
inline int fit_lengths(LengthFit& p, double time) {
    double* const pose = p.fit.pose;
    for (int i = 0; i < 7 && !(time > 0.0); i++) pose[i] = p.start[i];
    if (*p.fresh == 0.0) return 0;
    double before[7];
    for (int i = 0; i < 7; i++) before[i] = pose[i];
    *p.fits = fit_pose(p.fit) > 0 ? 1.0 : 0.0;
    p.fit.residual[0] = *p.fits > 0.0 ? square_root(p.fit.cost(p.fit.state)) : NOT_A_NUMBER;
    for (int i = 0; i < 7 && *p.fits == 0.0; i++) pose[i] = before[i];
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
