// Pose of the platform from the lengths of its cables, by damped least squares. SPDX-License-Identifier: Apache-2.0
//
// Gauss-Newton step, J^T J step = J^T r with the differences r of the lengths and J = -W^T; damped, by a share of the
// diagonal (Marquardt 1963), only if it does not reduce |r|. Rotations are rotation vectors in world axes, so that no
// attitude is singular. Pott, Cable-Driven Parallel Robots (2018), chapter 4.
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/mechanics/geometry.hpp>

namespace cdpr::CDPR_TARGET {

struct ForwardKinematics {
    static constexpr int MOST_ITERATIONS = 100;
    // An undamped step shorter than this, m (rotations times the characteristic length), is the last one: convergence
    // is quadratic, or gains three digits a step if lengths disagree by a thousandth; the remaining error is below
    // 1e-12 m.
    static constexpr double LAST_STEP = 1e-9;
    // Near the optimum the sum of squares changes by less than its round-off: a step may raise it by this share.
    static constexpr double ROUND_OFF = 1e-10;
    static constexpr double FIRST_DAMPING = 1e-4, LEAST_DAMPING = 1e-7, MOST_DAMPING = 1e8;

    const double* lines;    // (m, w), w >= 6, as of geometry.hpp
    const int64_t* rows;    // (n), 0 to 5, degrees of freedom: rows of a twist
    const double* scale;    // (n), factor that makes each a length: 1, or the characteristic length, m
    const double* target;   // (m), m, lengths
    double* pose;           // (7), position, m, and unit quaternion: the start, then the fit
    double* inverse;        // (n, n), (J^T J)^-1, infinite if J is rank-deficient
    double* residual;       // (1), m, norm of the remaining differences
    double* state;          // (13), work space: the pose at rest
    double* trial;          // (13), work space: the next one
    double* matrix;         // (6, m), work space: W
    double* length;         // (m), work space
    double* rate;           // (m), work space
    double* normal_matrix;  // (n, n), work space: J^T J, then its factor
    double* gradient;       // (n), work space: J^T r
    double* step;           // (n), work space: a twist times one second
    int64_t m;
    int64_t w;
    int64_t n;
    static constexpr char fields[] =
        "lines(m, w >= 6), rows(n), scale(n), target(m), both pose(7), inverse(n, n), residual(1), work state(13), "
        "work trial(13), work matrix(6, m), work length(m), work rate(m), work normal_matrix(n, n), work gradient(n), "
        "work step(n), m, w, n";

    CDPR_INLINE Matrix<double> A() const { return {normal_matrix, n}; }

    inline double cost(const double* at) const;
    inline void linearise() const;
    inline void move() const;
    inline bool iterate(double& squares, double& damping) const;
    inline void invert() const;
};

// Write W and the lengths at a state; return the sum of squared differences, m^2.
inline double ForwardKinematics::cost(const double* at) const {
    Geometry<double> cables = {lines, at, matrix, length, rate, m, w};
    geometry(cables);
    return sum(0.0, 0, m, [&](int64_t i) {
        const double difference = target[i] - length[i];
        return difference * difference;
    });
}

// Write J^T J and J^T r at the state of the last computed cost. A length shrinks along +u.
inline void ForwardKinematics::linearise() const {
    const Matrix<double> W = {matrix, m};
    for (int64_t k = 0; k < n; k++) {
        const double* row = W[rows[k]];
        gradient[k] = difference(0.0, 0, m, [&](int64_t i) { return row[i] * (target[i] - length[i]); });
        for (int64_t j = 0; j <= k; j++) A()(k, j) = sum(0.0, 0, m, [&](int64_t i) { return row[i] * W(rows[j], i); });
    }
}

// Write into `trial` the state moved by the step.
inline void ForwardKinematics::move() const {
    double turn[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < 3; i++) trial[i] = state[i];
    for (int64_t k = 0; k < n; k++) {
        if (rows[k] < 3)
            trial[rows[k]] += step[k];
        else
            turn[rows[k] - 3] = step[k];
    }
    const Quaternion<double> q = multiply(exponential(vector(turn)), quaternion(state + 3));
    const double norm = square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    store(Quaternion<double>{q.w / norm, q.x / norm, q.y / norm, q.z / norm}, trial + 3);
}

// Make one step if it reduces the squared differences, else raise the damping; return whether it is the last one.
inline bool ForwardKinematics::iterate(double& squares, double& damping) const {
    linearise();
    if (factorise(A(), n, damping)) {
        solve(A(), gradient, step, n);
        const double size = sum(0.0, 0, n, [&](int64_t k) {
            const double part = scale[k] * step[k];
            return part * part;
        });
        move();
        const bool converged = damping == 0.0 && size <= LAST_STEP * LAST_STEP;
        const double then = converged ? 0.0 : cost(trial);
        if (converged || then <= squares * (1.0 + ROUND_OFF)) {
            for (int i = 0; i < 7; i++) state[i] = trial[i];
            squares = then;
            damping = damping > LEAST_DAMPING ? 0.1 * damping : 0.0;
            return converged;
        }
    }
    damping = larger(10.0 * damping, FIRST_DAMPING);
    squares = cost(state);
    return false;
}

// Write (J^T J)^-1 of a linearised state.
inline void ForwardKinematics::invert() const {
    const bool determined = factorise(A(), n, 0.0);
    for (int64_t k = 0; k < n; k++) {
        for (int64_t j = 0; j < n; j++) gradient[j] = j == k ? 1.0 : 0.0;
        if (determined) solve(A(), gradient, step, n);
        for (int64_t j = 0; j < n; j++) inverse[j * n + k] = determined ? step[j] : INFINITE;
    }
}

// Fit the pose to the lengths, without covariance and residual. Return the number of iterations, negative without
// convergence; 0 for bad input.
inline int fit_pose(const ForwardKinematics& fit) {
    for (int64_t k = 0; k < fit.n; k++)
        if (fit.rows[k] < 0 || fit.rows[k] > 5) return 0;
    if (!has_anchors<double>(fit.w)) return 0;
    for (int i = 0; i < 13; i++) fit.state[i] = fit.trial[i] = i < 7 ? fit.pose[i] : 0.0;
    double squares = fit.cost(fit.state), damping = 0.0;
    int count = 0;
    bool converged = false;
    while (count < fit.MOST_ITERATIONS && damping <= fit.MOST_DAMPING && !converged) {
        count++;
        converged = fit.iterate(squares, damping);
    }
    for (int i = 0; i < 7; i++) fit.pose[i] = fit.state[i];
    return converged ? count : -count;
}

// Fit the pose to the lengths, and write its covariance and residual, too. Return as `fit_pose`.
inline int forward_kinematics(ForwardKinematics& fit) {
    const int count = fit_pose(fit);
    if (count == 0) return 0;
    fit.residual[0] = square_root(fit.cost(fit.state));
    fit.linearise();
    fit.invert();
    return count;
}

}  // namespace cdpr::CDPR_TARGET
