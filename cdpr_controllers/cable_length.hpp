// Control of each cable's length and rate: cdpr_controllers/cable_length.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/forward_kinematics.hpp>
#include <cdpr_controllers/holding.hpp>

namespace cdpr::CDPR_TARGET {

struct CableLengthControl {
    Holding holding;
    const double* state;    // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    const double* desired;  // (19): the same, and accelerations
    const double* sensed;   // (2, m): measured lengths, m, and rates, m/s
    const double* gains;    // (4, m): kp, N/m; kd, N s/m; ki times the control step, N/m; limit of the integral, N
    const double* limits;   // (2, m), N
    const double* scale;    // (n), as of ForwardKinematics
    double* pose;           // (7): the estimate
    double* tracking;       // (1), 1 if the estimate fits the lengths of the previous step
    double* integral;       // (m), N
    double* command;        // (m), N
    double* measured;       // (2, m), work space: lengths and rates
    double* wanted;         // (2, m), work space: the same of the desired state
    double* inverse;        // (n, n), work space; this and the following: forward_kinematics.hpp
    double* residual;       // (1)
    double* trial;          // (13)
    double* normal_matrix;  // (n, n)
    double* gradient;       // (n)
    double* step;           // (n)
    int64_t senses;         // 1: `sensed` contains the measurements; 0: they are computed from the state
    int64_t estimates;      // 1: estimate the pose from the lengths; 0: compute the feed-forward at the desired pose
    static constexpr auto fields = extended(
        Holding::fields.text,
        "state(13), desired(19), sensed(2, m), gains(4, m), limits(2, m), scale(n), both pose(7), both tracking(1), "
        "both integral(m), command(m), work measured(2, m), work wanted(2, m), work inverse(n, n), work residual(1), "
        "work trial(13), work normal_matrix(n, n), work gradient(n), work step(n), senses, estimates");

    CDPR_INLINE Geometry<double> cables(const double* at, double* answer) const {
        return {holding.lines, at, holding.whole_matrix, answer, answer + holding.m, holding.m, holding.w};
    }
    CDPR_INLINE ForwardKinematics fit() const {
        const Holding& p = holding;
        return {p.lines,        p.rows,    scale,           measured,      pose,     inverse, residual, p.still, trial,
                p.whole_matrix, p.lengths, p.lengths + p.m, normal_matrix, gradient, step,    p.m,      p.w,     p.n};
    }
};

// Write measured and desired lengths and rates.
inline void measure(const CableLengthControl& p) {
    Geometry<double> now = p.cables(p.state, p.measured), then = p.cables(p.desired, p.wanted);
    if (!p.senses) geometry(now);
    for (int64_t i = 0; p.senses && i < 2 * p.holding.m; i++) p.measured[i] = p.sensed[i];
    geometry(then);
}

// Write the pose of the feed-forward: the fit to the lengths, with the previous pose as its start; or the desired pose
// at first, after a failed fit, and without estimation.
inline void estimate(const CableLengthControl& p) {
    if (*p.tracking == 0.0)
        for (int i = 0; i < 7; i++) p.pose[i] = p.desired[i];
    if (!p.estimates) return;
    *p.tracking = fit_pose(p.fit()) > 0;
    if (*p.tracking == 0.0)
        for (int i = 0; i < 7; i++) p.pose[i] = p.desired[i];
}

// Write the commands and advance the integrals. An integral does not grow while its cable is at the tension limit in
// that direction.
inline void write_commands(const CableLengthControl& p) {
    const int64_t m = p.holding.m;
    for (int64_t i = 0; i < m; i++) {
        const double kp = p.gains[i], kd = p.gains[m + i], limit = p.gains[3 * m + i];
        const double error = p.measured[i] - p.wanted[i], change = p.gains[2 * m + i] * error;
        const double grown = smaller(larger(p.integral[i] + change, -limit), limit);
        const double t = p.holding.feed[i] + kp * error + kd * (p.measured[m + i] - p.wanted[m + i]);
        const bool pushes_up = t + grown > p.limits[m + i] - LIMIT_TOLERANCE && change > 0.0;
        const bool pushes_down = t + grown < p.limits[i] + LIMIT_TOLERANCE && change < 0.0;
        if (!(pushes_up || pushes_down) || p.integral[i] * change < 0.0) p.integral[i] = grown;
        p.command[i] = t + p.integral[i];
    }
}

inline int cable_length(CableLengthControl& p) {
    if (!has_anchors<double>(p.holding.w)) return BAD_INPUT;
    measure(p);
    estimate(p);
    hold(p.holding, p.pose);
    write_commands(p);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
