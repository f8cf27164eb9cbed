// Stiffness of a platform held by its cables: cdpr/mechanics/stiffness.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

// Share of the largest tension up to which a cable is slack: it is at its lower limit of 0, and has no stiffness.
constexpr double SLACK = 1e-9;

struct Stiffness {
    const double* lines;            // (m, w), as in Geometry
    const double* axial_stiffness;  // (m), E A, N; 0 for cables without stiffness of their own
    const double* inertial;         // (13), `Robot.inertial`
    const double* gravity;          // (3), m/s^2, world
    const double* poses;            // (k, 7): position, m, and quaternion
    const double* tension;          // (k, m), N
    double* stiffness;              // (k, 6, 6), N/m, N, N m
    double* matrices;               // (k, 6, m), wrench matrices
    double* state;                  // (13), work space
    double* rates;                  // (6, 6, m), work space: of W, for a unit velocity along each direction
    double* length;                 // (m), work space
    double* spare;                  // (m), work space
    int64_t unilateral;             // 1: cables without tension are slack, and no springs
    int64_t k;
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), axial_stiffness(m), inertial(13), gravity(3), poses(k, 7), tension(k, m), "
        "stiffness(k, 6, 6), matrices(k, 6, m), work state(13), work rates(6, 6, m), work length(m), work spare(m), "
        "unilateral, k, m, w";
};

// Write W, lengths, and the rates of W at a pose.
inline void write_geometry(const Stiffness& held, const double* pose, double* W) {
    for (int i = 0; i < 13; i++) held.state[i] = i < 7 ? pose[i] : 0.0;
    Geometry<double> cables = {held.lines, held.state, W, held.length, held.spare, held.m, held.w};
    geometry(cables);
    for (int j = 0; j < 6; j++) {
        MatrixRate<double> moving = {held.lines, held.state, held.rates + 6 * held.m * j, held.m, held.w};
        held.state[7 + j] = 1.0;
        matrix_rate(moving);
        held.state[7 + j] = 0.0;
    }
}

// Return an entry of the cables' stiffness: W diag((E A + t) / l) W^T of the taut ones, and -(dW t).
inline double cable_stiffness(const Stiffness& held, const double* W, const double* t, double slack, int i, int j) {
    const int64_t m = held.m;
    const double *rate = held.rates + (6 * j + i) * m, *axial = held.axial_stiffness;
    double total = 0.0;
    for (int64_t c = 0; c < m; c++) {
        const bool taut = !held.unilateral || t[c] > slack;
        if (taut && axial[c] > 0.0) total += W[i * m + c] * W[j * m + c] * (axial[c] + t[c]) / held.length[c];
        total -= rate[c] * t[c];
    }
    return total;
}

// Add the stiffness of the weight f at a rotating arm c: -d(c x f) = (c . f) dtheta - c (f . dtheta).
inline void add_weight(const Stiffness& held, const double* pose, double* K) {
    const Inertial<double> body = {held.inertial};
    double arm[3];
    store(body.lever(quaternion(pose + 3)), arm);
    const double mass = body.mass(), along = mass * dot(vector(held.gravity), vector(arm));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) K[6 * (3 + i) + 3 + j] += (i == j ? along : 0.0) - mass * arm[i] * held.gravity[j];
}

inline int stiffness(Stiffness& held) {
    if (!has_anchors<double>(held.w)) return BAD_INPUT;
    for (int64_t k = 0; k < held.k; k++) {
        const double *pose = held.poses + 7 * k, *t = held.tension + held.m * k;
        double *W = held.matrices + 6 * held.m * k, *K = held.stiffness + 36 * k;
        write_geometry(held, pose, W);
        double largest = 0.0;
        for (int64_t c = 0; c < held.m; c++) largest = larger(largest, absolute(t[c]));
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++) K[6 * i + j] = cable_stiffness(held, W, t, SLACK * largest, i, j);
        add_weight(held, pose, K);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
