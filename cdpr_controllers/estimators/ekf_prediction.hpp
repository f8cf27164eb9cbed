// Prediction of an error-state Kalman filter: ekf_prediction.py. SPDX-License-Identifier: Apache-2.0
//
// Error state (12): position, m, world axes; attitude e, rad, platform axes, q = q_estimate exp(e); velocity, m/s, and
// angular velocity, rad/s, world axes (Sola (2017), "Quaternion kinematics for the error-state Kalman filter", section
// 5, but with the world's axes for the angular velocity, so that e' = R^T d omega has no further term).
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/platform_acceleration.hpp>

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
    double* matrix;          // (6, m), work space: W
    double* length;          // (m), work space, m
    double* rate;            // (m), work space, m/s
    double* matrix_rate;     // (6, m), work space: W'
    double* forces;          // (m), work space, N
    double period;           // s, of control
    int64_t driven;          // 1: forced by tensions; 0: unknown tensions balance the weight
    int64_t rotates;         // 1: `inverse` applies; 0: guided, or drums with inertia, so M is factorised at each step
    int64_t noisy;           // 1: tensions are measured, with `spread`; NaN until the first measurement
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), chains(m, 33), inertial(13), inverse(6, 6), gravity(3), free(6), noise(2, 2), spread(m), "
        "work matrix(6, m), work length(m), work rate(m), work matrix_rate(6, m), work forces(m), period, driven, rotates, noisy, m, w";
};

// Dynamics at a state: accelerations (6), linear and angular, and their derivatives.
struct LinearisedMotion {
    double inverse[6][6];     // of the mass matrix; 0 in blocked directions
    double stiffness[6][6];   // of the wrench by position and rotation vector, world axes
    double gyroscopic[6][3];  // of the wrench by the angular velocity
    double acceleration[6];
};

CDPR_INLINE Vector<double> unit_vector(int j) { return {j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0}; }

// Write B = R A R^T, 3 x 3, within matrices with rows of six numbers; `axes` are the columns of R.
CDPR_INLINE void rotate_block(const Vector<double>* axes, const double* A, double* B) {
    double turned[3][3];  // R A
    for (int j = 0; j < 3; j++) {
        const Vector<double> column = {A[j], A[6 + j], A[12 + j]};
        const Vector<double> x = column.x * axes[0] + column.y * axes[1] + column.z * axes[2];
        turned[0][j] = x.x, turned[1][j] = x.y, turned[2][j] = x.z;
    }
    for (int i = 0; i < 3; i++) {
        const Vector<double> row = turned[i][0] * axes[0] + turned[i][1] * axes[1] + turned[i][2] * axes[2];
        store(row, B + 6 * i);
    }
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

// Add the stiffness of cables with these tensions, N: with tau = t / l and b from the platform's origin to the anchor,
// -tau (J^T J - w w^T), J = [1, -[b]x], and the moment (phi x b) x t u of a rotation phi.
inline void add_stiffness(const FilteredPlatform& p, const double* tension, Quaternion<double> q,
                          LinearisedMotion& now) {
    const int64_t m = p.m;
    double total = 0.0, first[3] = {}, second[3][3] = {}, along[3][3] = {};
    for (int64_t i = 0; i < m; i++) {
        double b[3], w[6];
        store(rotate(q, vector(p.lines + i * p.w + Line<double>::PLATFORM)), b);
        for (int j = 0; j < 6; j++) w[j] = p.matrix[j * m + i];
        const double t = tension[i], tau = t / p.length[i];
        total += tau;
        for (int j = 0; j < 3; j++) {
            first[j] += tau * b[j];
            for (int k = 0; k < 3; k++) second[j][k] += tau * b[j] * b[k];
            for (int k = 0; k < 3; k++) along[j][k] += t * b[j] * w[k];
        }
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 6; k++) now.stiffness[j][k] += tau * w[j] * w[k];
    }
    const double trace = second[0][0] + second[1][1] + second[2][2];
    const double straight = along[0][0] + along[1][1] + along[2][2];
    for (int j = 0; j < 3; j++) {
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        now.stiffness[j][j] -= total;
        now.stiffness[k][3 + l] -= first[j];  // tau [b]x above, its transpose below
        now.stiffness[l][3 + k] += first[j];
        now.stiffness[3 + k][l] += first[j];
        now.stiffness[3 + l][k] -= first[j];
        now.stiffness[3 + j][3 + j] -= trace + straight;
        for (int i = 0; i < 3; i++) now.stiffness[3 + j][3 + i] += second[j][i] + along[j][i];
    }
}

// Write the wrench (6) that tensions and inertia leave over, and its derivatives except those of the inertia by the
// attitude, which are of second order.
inline void write_wrench(const FilteredPlatform& p, const double* state, const double* tension, double* wrench,
                         LinearisedMotion& now) {
    const Inertial<double> body = {p.inertial};
    const Quaternion<double> q = quaternion(state + 3);
    const Vector<double> spin = vector(state + 10), none = no_vector<double>(), r = body.lever(q);
    const Vector<double> weight = body.mass() * vector(p.gravity);
    store(inverse_dynamics<double>(body, vector(p.gravity), q, spin, none, none), wrench);
    for (int j = 0; j < 6; j++) {
        const double* row = p.matrix + j * p.m;
        wrench[j] = sum(-wrench[j], 0, p.m, [&](int64_t i) { return row[i] * tension[i]; });
        for (int k = 0; k < 6; k++) now.stiffness[j][k] = 0.0;
    }
    add_stiffness(p, tension, q, now);
    const double lever[3] = {r.x, r.y, r.z}, pull[3] = {weight.x, weight.y, weight.z};
    const double straight = dot(r, weight);
    const Vector<double> momentum = body.turned_times(q, spin), turning = cross(spin, r);
    for (int j = 0; j < 3; j++) {
        now.stiffness[3 + j][3 + j] -= straight;
        for (int k = 0; k < 3; k++) now.stiffness[3 + j][3 + k] += lever[j] * pull[k];
        const Vector<double> e = unit_vector(j);
        const Vector<double> force = -body.mass() * (cross(e, turning) + cross(spin, cross(e, r)));
        const Vector<double> moment = cross(momentum, e) - cross(spin, body.turned_times(q, e)) + cross(r, force);
        now.gyroscopic[0][j] = force.x, now.gyroscopic[1][j] = force.y, now.gyroscopic[2][j] = force.z;
        now.gyroscopic[3][j] = moment.x, now.gyroscopic[4][j] = moment.y, now.gyroscopic[5][j] = moment.z;
    }
}

// Write the inverse mass matrix; replace the commands of winches with inertia, N, by the tensions of their cables at a
// platform without acceleration.
inline void write_inverse(const FilteredPlatform& p, bool driven, const double* state, const Vector<double>* axes,
                          double* tension, LinearisedMotion& now) {
    if (p.rotates) {
        for (int j = 0; j < 4; j++) {
            const int place = 18 * (j / 2) + 3 * (j % 2);
            rotate_block(axes, p.inverse + place, &now.inverse[0][0] + place);
        }
        return;
    }
    MatrixRate<double> moving = {p.lines, state, p.matrix_rate, p.m, p.w};
    if (driven) matrix_rate(moving);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<double> chain = chain_row(p.chains, i);
        double own[MOST_STATES] = {}, later = 0.0;  // later: the acceleration of the length
        WinchTension<double> found = {tension[i], 0.0};
        for (int j = 0; driven && j < 6; j++) later -= p.matrix_rate[j * p.m + i] * state[7 + j];
        if (driven && !p.noisy) found = chain.held(own, tension[i], p.length[i], p.rate[i], later);
        tension[i] = found.tension;
        p.rate[i] = found.mass;
    }
    invert_mass_matrix(p, quaternion(state + 3), p.rate, now);
}

// Write the accelerations at a state with these tensions, N, and their derivatives.
inline void linearise_motion(const FilteredPlatform& p, bool driven, const double* state, const Vector<double>* axes,
                             double* tension, LinearisedMotion& now) {
    Geometry<double> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    write_inverse(p, driven, state, axes, tension, now);
    double wrench[6] = {};
    if (driven) {
        write_wrench(p, state, tension, wrench, now);
    } else {
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 6; k++) now.stiffness[j][k] = now.gyroscopic[j][k % 3] = 0.0;
    }
    for (int j = 0; j < 6; j++)
        now.acceleration[j] = sum(0.0, 0, 6, [&](int64_t k) { return now.inverse[j][k] * wrench[k]; });
}

// Rates of the velocity errors by the error state, and the covariance of a step's change of velocities.
struct ErrorMotion {
    double rows[6][ERRORS];   // by position, attitude and angular velocity, 1/s; those by velocity are 0
    double noise[6][ERRORS];  // with the error state
};

// Write the change of the velocity errors over a step, and its noise, which acts on positions by half a step.
inline void write_error_motion(const FilteredPlatform& p, bool driven, const Vector<double>* axes,
                               const LinearisedMotion& now, ErrorMotion& step) {
    const double h = p.period;
    double density[6][6] = {}, spread[6][6];
    for (int j = 0; j < 6; j++) density[j][j] = p.noise[(driven ? 0 : 2) + j / 3];
    for (int64_t i = 0; driven && p.noisy && i < p.m; i++)
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 6; k++)
                density[j][k] += p.matrix[j * p.m + i] * p.spread[i] * p.matrix[k * p.m + i];
    for (int j = 0; j < 6; j++) {
        double* const row = step.rows[j];
        double turn[3], product[6];
        for (int k = 0; k < ERRORS; k++) row[k] = 0.0;
        for (int k = 0; k < 6; k++) product[k] = 0.0;
        for (int i = 0; i < 6; i++)
            for (int k = 0; k < 6; k++) product[k] += now.inverse[j][i] * now.stiffness[i][k];
        for (int k = 0; k < 3; k++) row[k] = h * product[k], turn[k] = h * product[3 + k];
        for (int k = 0; k < 3; k++) row[TURN_ERROR + k] = dot(vector(turn), axes[k]);
        for (int i = 0; i < 6; i++)
            for (int k = 0; k < 3; k++) row[SPIN_ERROR + k] += h * now.inverse[j][i] * now.gyroscopic[i][k];
        for (int k = 0; k < 6; k++) {
            spread[j][k] = 0.0;
            for (int i = 0; i < 6; i++) spread[j][k] += now.inverse[j][i] * density[i][k];
        }
    }
    for (int j = 0; j < 6; j++) {
        double* const row = step.noise[j];
        for (int k = 0; k < 6; k++)
            row[VELOCITY_ERROR + k] = h * sum(0.0, 0, 6, [&](int64_t i) { return spread[j][i] * now.inverse[k][i]; });
        for (int k = 0; k < 3; k++) {
            row[k] = 0.5 * h * row[VELOCITY_ERROR + k];
            row[TURN_ERROR + k] = 0.5 * h * dot(vector(row + SPIN_ERROR), axes[k]);
        }
    }
}

// Write Y = F X + G noise of X (12, 12); without noise Y = F X.
template <bool noisy>
inline void transition(const double (*X)[ERRORS], const ErrorMotion& step, const Vector<double>* axes, double h,
                       double (*Y)[ERRORS]) {
    for (int j = 0; j < 6; j++) {
        double row[ERRORS];
        for (int k = 0; k < ERRORS; k++) row[k] = X[VELOCITY_ERROR + j][k] + (noisy ? step.noise[j][k] : 0.0);
        for (int i = 0; i < ERRORS; i++) {
            if (i >= VELOCITY_ERROR && i < SPIN_ERROR) continue;
            const double factor = step.rows[j][i];
            for (int k = 0; k < ERRORS; k++) row[k] += factor * X[i][k];
        }
        for (int k = 0; k < ERRORS; k++) Y[VELOCITY_ERROR + j][k] = row[k];
    }
    for (int j = 0; j < 3; j++) {
        const double along[3] = {0.5 * h * axes[j].x, 0.5 * h * axes[j].y, 0.5 * h * axes[j].z};
        for (int k = 0; k < ERRORS; k++) {
            Y[j][k] = X[j][k] + 0.5 * h * (X[VELOCITY_ERROR + j][k] + Y[VELOCITY_ERROR + j][k]);
            double turned = X[TURN_ERROR + j][k];
            for (int i = 0; i < 3; i++) turned += along[i] * (X[SPIN_ERROR + i][k] + Y[SPIN_ERROR + i][k]);
            Y[TURN_ERROR + j][k] = turned;
        }
    }
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
    linearise_motion(p, driven, middle, axes, tension, now);
    ErrorMotion step;
    write_error_motion(p, driven, axes, now, step);
    double* const a = now.acceleration;
    double later[6];  // the angular velocity is that of the middle, too
    for (int j = 0; j < 6; j++)
        later[j] = a[j] + 0.5 * sum(0.0, 0, 3, [&](int64_t k) { return step.rows[j][SPIN_ERROR + k] * a[3 + k]; });
    const Vector<double> linear = vector(later), angular = vector(later + 3);
    store(vector(before) + h * velocity + 0.5 * h * h * linear, after);
    store(multiply(exponential(h * spin + 0.5 * h * h * angular), quaternion(before + 3)), after + 3);
    store(velocity + h * linear, after + 7);
    store(spin + h * angular, after + 10);
    double X[ERRORS][ERRORS], Y[ERRORS][ERRORS];
    transition<false>(reinterpret_cast<const double (*)[ERRORS]>(covariance), step, axes, h, Y);
    for (int j = 0; j < ERRORS; j++)
        for (int k = 0; k < ERRORS; k++) X[j][k] = Y[k][j];
    transition<true>(X, step, axes, h, Y);
    for (int j = 0; j < ERRORS; j++)
        for (int k = 0; k < ERRORS; k++) predicted[ERRORS * j + k] = j < k ? Y[j][k] : Y[k][j];
}

}  // namespace cdpr::CDPR_TARGET
