// Prediction of an error-state Kalman filter: ekf_prediction.py. SPDX-License-Identifier: Apache-2.0
//
// Error state (12): position, m, world axes; attitude e, rad, platform axes, q = q_estimate exp(e); velocity, m/s, and
// angular velocity, rad/s, world axes (Sola (2017), "Quaternion kinematics for the error-state Kalman filter", section
// 5, but with the world's axes for the angular velocity, so that e' = R^T d omega has no further term).
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/platform_acceleration.hpp>
#include <cdpr/twelve.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int ERRORS = 12;
enum ErrorState { PLACE_ERROR = 0, TURN_ERROR = 3, VELOCITY_ERROR = 6, SPIN_ERROR = 9 };

// Nominal robot, as far as it moves the platform.
struct FilteredPlatform {
    const double* lines;     // (m, w), as in Geometry
    const double* chains;    // (m, 33), chain.hpp
    const double* inertial;  // (13), `Robot.inertial`
    const double* inverse;   // (6, 6), inverse mass matrix about the platform's origin, platform axes
    const double* gravity;   // (3), m/s^2, world
    const double* free;      // (6), 1 for each free row of a twist, 0 for directions blocked by a guide
    const double* noise;     // (2, 2), white force, N^2 s, and moment, (N m)^2 s, about the platform's origin: with
                             // known tensions, and without
    const double* spread;    // (m), N^2 s, white noise of the tensions
    const double* cells;     // (m), N, standard deviation of the measured tensions
    double* matrix;          // (6, m), work space: W
    double* length;          // (m), work space, m
    double* rate;            // (m), work space, m/s
    double* matrix_rate;     // (6, m), work space: W'
    double* forces;          // (m), work space, N
    double period;           // s, of control
    int64_t driven;          // 1: forced by tensions; 0: unknown tensions balance the weight
    int64_t rotates;         // 1: `inverse` applies; 0: guided, or drums with inertia, so M is factorised at each step
    int64_t elastic;         // 1: a cable stretches
    int64_t drums;           // 1: drums of cables that stretch have states; 0: they follow their cables at once
    int64_t noisy;           // 1: tensions are measured, with `spread`; NaN until the first measurement
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), chains(m, 33), inertial(13), inverse(6, 6), gravity(3), free(6), noise(2, 2), spread(m), "
        "cells(m), "
        "work matrix(6, m), work length(m), work rate(m), work matrix_rate(6, m), work forces(m), period, driven, "
        "rotates, elastic, drums, noisy, m, w";
};

// Dynamics at a state.
struct LinearisedMotion {
    double inverse[6][6];           // of the mass matrix; 0 in blocked directions
    double wrench_rate[6][ERRORS];  // derivatives of the wrench by the error state
    double acceleration[6];         // linear and angular
    bool rubs;                      // the wrench depends on the velocities by friction of winches
};

CDPR_INLINE Vector<double> unit_vector(int j) { return {j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0}; }

// Write B = R A R^T, 3 x 3, within matrices with rows of `stride` numbers; `axes` are the columns of R.
CDPR_INLINE void rotate_block(const Vector<double>* axes, const double* A, int stride, double* B) {
    double turned[3][3];  // R A, by columns
    CDPR_UNROLL
    for (int j = 0; j < 3; j++) {
        const Vector<double> column = {A[j], A[stride + j], A[2 * stride + j]};
        store(column.x * axes[0] + column.y * axes[1] + column.z * axes[2], turned[j]);
    }
    CDPR_UNROLL
    for (int i = 0; i < 3; i++)
        store(turned[0][i] * axes[0] + turned[1][i] * axes[1] + turned[2][i] * axes[2], B + stride * i);
}

// Write the inverse mass matrix of a guided platform, or of one with the masses (m), kg, of drums along the cables.
inline void invert_mass_matrix(const FilteredPlatform& p, Quaternion<double> q, const double* mass,
                               LinearisedMotion& now) {
    PlatformDynamics<double> body;
    body.write_mass_matrix({p.inertial}, q, Inertial<double>{p.inertial}.lever(q), p.free);
    for (int64_t i = 0; i < p.m; i++) {
        if (mass[i] == 0.0) continue;
        for (int j = 0; j < 6; j++)
            for (int k = 0; k <= j; k++)
                body.mass_matrix[6 * j + k] +=
                    mass[i] * p.matrix[j * p.m + i] * p.free[j] * p.matrix[k * p.m + i] * p.free[k];
    }
    const Matrix<double> M = {body.mass_matrix, 6};
    const bool regular = factorise(M, 6, 0.0);
    for (int k = 0; k < 6; k++) {
        double unit[6] = {}, column[6];
        unit[k] = 1.0;
        if (regular) solve(M, unit, column, 6);
        for (int j = 0; j < 6; j++) now.inverse[j][k] = regular ? column[j] * p.free[j] * p.free[k] : NOT_A_NUMBER;
    }
}

// Write the stiffness (6, 6), by position and rotation vector, world axes, of cables with these tensions, N, and of the
// weight, which acts at r. With tau = t / l and b from the platform's origin to the anchor it is -tau (J^T J - w w^T),
// J = [1, -[b]x], and the moment (phi x b) x t u of a rotation phi.
inline void write_stiffness(const FilteredPlatform& p, const double* tension, Quaternion<double> q, Vector<double> r,
                            Vector<double> weight, double (*stiffness)[6]) {
    const int64_t m = p.m;
    double total = 0.0, along[6][6] = {}, levers[3][7] = {};  // levers: sums of b times t u, tau b and tau
    for (int64_t i = 0; i < m; i++) {
        const Vector<double> b = rotate(q, vector(p.lines + i * p.w + Line<double>::PLATFORM));
        const double t = tension[i], tau = t / p.length[i], anchor[3] = {b.x, b.y, b.z};
        double w[6];
        CDPR_UNROLL
        for (int j = 0; j < 6; j++) w[j] = p.matrix[j * m + i];
        CDPR_UNROLL
        for (int j = 0; j < 6; j++) {
            CDPR_UNROLL
            for (int k = 0; k <= j; k++) along[j][k] += tau * w[j] * w[k];
        }
        CDPR_UNROLL
        for (int j = 0; j < 3; j++) {
            CDPR_UNROLL
            for (int k = 0; k < 3; k++) {
                levers[j][k] += anchor[j] * (t * w[k]);
                levers[j][3 + k] += anchor[j] * (tau * anchor[k]);
            }
            levers[j][6] += tau * anchor[j];
        }
        total += tau;
    }
    const double lever[3] = {r.x, r.y, r.z}, pull[3] = {weight.x, weight.y, weight.z};
    double square = 0.0, straight = dot(r, weight);
    for (int j = 0; j < 3; j++) square += levers[j][3 + j], straight += levers[j][j];
    for (int j = 0; j < 6; j++)
        for (int k = 0; k <= j; k++) stiffness[j][k] = stiffness[k][j] = along[j][k];
    for (int j = 0; j < 3; j++) {
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        const double first = levers[j][6];
        stiffness[j][j] -= total;
        stiffness[k][3 + l] -= first;  // tau [b]x above, its transpose below
        stiffness[l][3 + k] += first;
        stiffness[3 + k][l] += first;
        stiffness[3 + l][k] -= first;
        stiffness[3 + j][3 + j] -= square + straight;
        for (int i = 0; i < 3; i++) stiffness[3 + j][3 + i] += levers[j][3 + i] + levers[j][i] + lever[j] * pull[i];
    }
}

// Return whether the filter has a state of the stretch of a cable; that of spans with states of their own is at rest.
CDPR_INLINE bool has_stretch_state(ChainRow<double> chain) {
    return chain.stretches() && span_states(chain.span_kind()) == 0;
}

constexpr double SPEED_STEP = 1e-3;  // rad/s, of numerical derivatives: far below speeds at which friction bends

// Return the friction of a winch that moves with its cable, N s/m: the mean slope of the tension over rates with this
// standard deviation, m/s, for Coulomb friction bends within it. Differences over sqrt(3) deviations: Norgaard, Poulsen,
// Ravn, New developments in state estimation for nonlinear systems, Automatica 36 (2000), section 3.
CDPR_INLINE double friction_slope(ChainRow<double> chain, double command, double length, double rate,
                                  double deviation) {
    const double own[MOST_STATES] = {}, least = SPEED_STEP * chain.per_turn(length);
    if (!(least > 0.0)) return 0.0;  // no drum
    const double step = hypotenuse(least, square_root(3.0) * deviation);
    const double high = chain.held(own, command, length, rate + step, 0.0).tension;
    const double low = chain.held(own, command, length, rate - step, 0.0).tension;
    return larger((high - low) / (2.0 * step), 0.0);
}

// Return the standard deviation of the rate of cable i, m/s, with this covariance (12, 12) of the error state.
CDPR_INLINE double rate_deviation(const FilteredPlatform& p, const double* covariance, int64_t i) {
    const double* const P = covariance + (ERRORS + 1) * VELOCITY_ERROR;
    double total = 0.0;
    for (int j = 0; j < 6; j++)
        for (int k = 0; k < 6; k++) total += p.matrix[j * p.m + i] * P[ERRORS * j + k] * p.matrix[k * p.m + i];
    return square_root(larger(total, 0.0));
}

// Return whether a drum with a state of its own determines the tension of a cable.
CDPR_INLINE bool on_drum(const FilteredPlatform& p, ChainRow<double> chain) {
    return p.drums && has_stretch_state(chain);
}

// Rows of `matrix_rate` (m) that hold, after the use of W', a mass along each cable for the errors, kg, and the friction
// of its winch, N s/m.
CDPR_INLINE double* masses_of_errors(const FilteredPlatform& p) { return p.matrix_rate; }
CDPR_INLINE double* friction_of_errors(const FilteredPlatform& p) { return p.matrix_rate + p.m; }

// Write the inverse mass matrix; replace the commands of winches that move with their cables, N, by the tensions at a
// platform without acceleration. Errors move drums at once, with an implicit step of the friction.
inline void write_inverse(const FilteredPlatform& p, bool driven, const double* state, const double* covariance,
                          const Vector<double>* axes, double* tension, LinearisedMotion& now) {
    now.rubs = false;
    if (p.rotates) {
        const int blocks[3] = {0, 3, 21};  // of the upper half
        for (const int place : blocks) rotate_block(axes, p.inverse + place, 6, &now.inverse[0][0] + place);
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) now.inverse[3 + k][j] = now.inverse[j][3 + k];
        return;
    }
    MatrixRate<double> moving = {p.lines, state, p.matrix_rate, p.m, p.w};
    if (driven) matrix_rate(moving);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<double> chain = chain_row(p.chains, i);
        double own[MOST_STATES] = {}, later = 0.0, slope = 0.0;  // later: the acceleration of the length
        WinchTension<double> found = {tension[i], 0.0};
        for (int j = 0; driven && j < 6; j++) later -= p.matrix_rate[j * p.m + i] * state[7 + j];
        if (driven && !p.noisy) {
            found = chain.held(own, tension[i], p.length[i], p.rate[i], later);
            const double deviation = rate_deviation(p, covariance, i);
            slope = friction_slope(chain, tension[i], p.length[i], p.rate[i], deviation);
        }
        const bool turns = on_drum(p, chain);
        if (!turns) tension[i] = found.tension;
        p.rate[i] = turns ? 0.0 : found.mass;
        masses_of_errors(p)[i] = found.mass + p.period * slope;
        friction_of_errors(p)[i] = slope;
        now.rubs = now.rubs || slope > 0.0;
    }
    invert_mass_matrix(p, quaternion(state + 3), p.rate, now);
}

// Write the wrench (6) that accelerates the platform, and its derivatives, without those of the inertia by the
// attitude, which are of second order.
inline void write_wrench(const FilteredPlatform& p, const double* state, const Vector<double>* axes,
                         const double* tension, double* wrench, LinearisedMotion& now) {
    const Inertial<double> body = {p.inertial};
    const Quaternion<double> q = quaternion(state + 3);
    const Vector<double> spin = vector(state + 10), none = no_vector<double>(), r = body.lever(q);
    store(inverse_dynamics<double>(body, vector(p.gravity), q, spin, none, none), wrench);
    for (int j = 0; j < 6; j++) {
        const double* row = p.matrix + j * p.m;
        wrench[j] = sum(-wrench[j], 0, p.m, [&](int64_t i) { return row[i] * tension[i]; });
    }
    double stiffness[6][6], inertia[9];
    write_stiffness(p, tension, q, r, body.mass() * vector(p.gravity), stiffness);
    for (int j = 0; j < 6; j++) {
        double* const row = now.wrench_rate[j];
        for (int k = 0; k < 3; k++) {
            row[k] = stiffness[j][k];
            row[TURN_ERROR + k] = dot(vector(stiffness[j] + 3), axes[k]);
            row[VELOCITY_ERROR + k] = 0.0;
        }
    }
    rotate_block(axes, p.inertial + Inertial<double>::INERTIA, 3, inertia);
    const Vector<double> momentum = product(inertia, spin), turning = cross(spin, r);
    for (int k = 0; k < 3; k++) {  // an angular velocity e more
        const Vector<double> e = unit_vector(k);
        const Vector<double> force = -body.mass() * (cross(e, turning) + cross(spin, cross(e, r)));
        const Vector<double> moment = cross(momentum, e) - cross(spin, vector(inertia + 3 * k)) + cross(r, force);
        const double column[6] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
        for (int j = 0; j < 6; j++) now.wrench_rate[j][SPIN_ERROR + k] = column[j];
    }
    for (int64_t i = 0; now.rubs && i < p.m; i++) {
        const double slope = friction_of_errors(p)[i];
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 6; k++)
                now.wrench_rate[j][VELOCITY_ERROR + k] -= slope * p.matrix[j * p.m + i] * p.matrix[k * p.m + i];
    }
}

// Write the accelerations at a state with these tensions, N, and the derivatives of the wrench.
inline void linearise_motion(const FilteredPlatform& p, bool driven, const double* state, const double* covariance,
                             const Vector<double>* axes, double* tension, LinearisedMotion& now) {
    Geometry<double> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    write_inverse(p, driven, state, covariance, axes, tension, now);
    double wrench[6] = {};
    if (driven) write_wrench(p, state, axes, tension, wrench, now);
    for (int j = 0; j < 6; j++) {
        for (int k = 0; !driven && k < ERRORS; k++) now.wrench_rate[j][k] = 0.0;
        now.acceleration[j] = sum(0.0, 0, 6, [&](int64_t k) { return now.inverse[j][k] * wrench[k]; });
    }
    if (driven && (now.rubs || (p.drums && !p.rotates)))
        invert_mass_matrix(p, quaternion(state + 3), masses_of_errors(p), now);
}

// Change of the velocity errors in a step, per error state, and covariance of its noise with the error state.
struct ErrorMotion {
    double change[6][ERRORS];
    Twelve noise[6];
    bool rubs;
};

CDPR_INLINE Twelve weighted(const double* weights, const Twelve* rows) {
    Twelve total = weights[0] * rows[0];
    CDPR_UNROLL
    for (int i = 1; i < 6; i++) total = total + weights[i] * rows[i];
    return total;
}

// Write them; the noise acts on positions by half a step.
inline void write_error_motion(const FilteredPlatform& p, bool driven, const Vector<double>* axes,
                               const LinearisedMotion& now, ErrorMotion& step) {
    const double h = p.period;
    step.rubs = now.rubs;
    Twelve rates[6], effects[6];
    for (int i = 0; i < 6; i++) {
        const double* const row = now.inverse[i];  // the effects of a wrench: the matrix is symmetric
        const Vector<double> linear = vector(row), angular = vector(row + 3);
        double effect[ERRORS];
        store(0.5 * h * linear, effect);
        for (int k = 0; k < 3; k++) effect[TURN_ERROR + k] = 0.5 * h * dot(angular, axes[k]);
        store(linear, effect + VELOCITY_ERROR);
        store(angular, effect + SPIN_ERROR);
        effects[i] = twelve(effect);
        rates[i] = twelve(now.wrench_rate[i]);
    }
    for (int j = 0; j < 6; j++) {
        double scaled[6], spread[6];
        for (int i = 0; i < 6; i++) {
            scaled[i] = h * now.inverse[j][i];
            spread[i] = scaled[i] * p.noise[(driven ? 0 : 2) + i / 3];
        }
        for (int64_t c = 0; driven && p.noisy && c < p.m; c++) {
            const double along =
                sum(0.0, 0, 6, [&](int64_t i) { return scaled[i] * p.matrix[i * p.m + c]; }) * p.spread[c];
            for (int i = 0; i < 6; i++) spread[i] += along * p.matrix[i * p.m + c];
        }
        store(weighted(scaled, rates), step.change[j]);
        step.noise[j] = weighted(spread, effects);
    }
}

// Write Y = F X + G noise of X (12, 12); without noise Y = F X.
template <bool noisy>
inline void transition(const Twelve* X, const ErrorMotion& step, const Vector<double>* axes, double h, Twelve* Y) {
    for (int j = 0; j < 6; j++) {
        Twelve row = X[VELOCITY_ERROR + j];
        if (noisy) row = row + step.noise[j];
        for (int i = 0; i < VELOCITY_ERROR; i++) row = row + step.change[j][i] * X[i];
        for (int i = VELOCITY_ERROR; step.rubs && i < SPIN_ERROR; i++) row = row + step.change[j][i] * X[i];
        for (int i = SPIN_ERROR; i < ERRORS; i++) row = row + step.change[j][i] * X[i];
        Y[VELOCITY_ERROR + j] = row;
    }
    Twelve turns[3];
    for (int j = 0; j < 3; j++) {
        Y[j] = X[j] + 0.5 * h * (X[VELOCITY_ERROR + j] + Y[VELOCITY_ERROR + j]);
        turns[j] = 0.5 * h * (X[SPIN_ERROR + j] + Y[SPIN_ERROR + j]);
    }
    for (int j = 0; j < 3; j++)
        Y[TURN_ERROR + j] = X[TURN_ERROR + j] + axes[j].x * turns[0] + axes[j].y * turns[1] + axes[j].z * turns[2];
}

// Write the predicted covariance (12, 12).
inline void predict_covariance(const ErrorMotion& step, const Vector<double>* axes, double h, const double* covariance,
                               double* predicted) {
    Twelve X[ERRORS], Y[ERRORS];
    for (int j = 0; j < ERRORS; j++) X[j] = twelve(covariance + ERRORS * j);
    transition<false>(X, step, axes, h, Y);
    double rows[ERRORS][ERRORS], columns[ERRORS][ERRORS];
    for (int j = 0; j < ERRORS; j++) store(Y[j], rows[j]);
    for (int j = 0; j < ERRORS; j++)
        for (int k = 0; k < ERRORS; k++) columns[j][k] = rows[k][j];
    for (int j = 0; j < ERRORS; j++) X[j] = twelve(columns[j]);
    transition<true>(X, step, axes, h, Y);
    for (int j = 0; j < ERRORS; j++) store(Y[j], predicted + ERRORS * j);
    for (int j = 0; j < ERRORS; j++)
        for (int k = 0; k < j; k++) predicted[ERRORS * j + k] = predicted[ERRORS * k + j];
}

// Advance state (13) and covariance (12, 12) by a control period under these tensions (m), N, which are overwritten:
// by the explicit midpoint rule.
inline void predict(const FilteredPlatform& p, const double* before, const double* covariance, double* tension,
                    double* after, double* predicted) {
    const double h = p.period;
    const bool driven = p.driven && tension[0] == tension[0];
    const Vector<double> velocity = vector(before + 7), spin = vector(before + 10);
    double middle[13];
    store(vector(before) + 0.5 * h * velocity, middle);
    store(multiply(exponential(0.5 * h * spin), quaternion(before + 3)), middle + 3);
    for (int j = 7; j < 13; j++) middle[j] = before[j];
    const Quaternion<double> q = quaternion(middle + 3);
    const Vector<double> axes[3] = {rotate(q, unit_vector(0)), rotate(q, unit_vector(1)), rotate(q, unit_vector(2))};
    LinearisedMotion now;
    linearise_motion(p, driven, middle, covariance, axes, tension, now);
    ErrorMotion step;
    write_error_motion(p, driven, axes, now, step);
    double* const a = now.acceleration;
    double later[6];  // with the angular velocity of the middle, too
    for (int j = 0; j < 6; j++)
        later[j] = a[j] + 0.5 * sum(0.0, 0, 3, [&](int64_t k) { return step.change[j][SPIN_ERROR + k] * a[3 + k]; });
    const Vector<double> linear = vector(later), angular = vector(later + 3);
    store(vector(before) + h * velocity + 0.5 * h * h * linear, after);
    store(multiply(exponential(h * spin + 0.5 * h * h * angular), quaternion(before + 3)), after + 3);
    store(velocity + h * linear, after + 7);
    store(spin + h * angular, after + 10);
    predict_covariance(step, axes, h, covariance, predicted);
}

}  // namespace cdpr::CDPR_TARGET
