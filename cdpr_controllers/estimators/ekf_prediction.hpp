// Prediction of an error-state Kalman filter: ekf_prediction.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/platform_acceleration.hpp>
#include <cdpr/strip.hpp>
#include <cdpr_controllers/estimators/ekf_tension_errors.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> CDPR_INLINE Vector<T> unit_vector(int j) {
    return {j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0};
}

// Cross product of the unit vector along axis k, and v.
template <class T> CDPR_INLINE Vector<T> unit_cross(int k, Vector<T> v) {
    if (k == 0) return {0.0, -v.z, v.y};
    if (k == 1) return {v.z, 0.0, -v.x};
    return {-v.y, v.x, 0.0};
}

// Write B = R A R^T, 3 x 3, within matrices with rows of `stride` numbers; `axes` are the columns of R.
template <class T> CDPR_INLINE void rotate_block(const Vector<T>* axes, const T* A, int stride, T* B) {
    T turned[3][3];  // R A, by columns
    CDPR_UNROLL
    for (int j = 0; j < 3; j++) {
        const Vector<T> column = {A[j], A[stride + j], A[2 * stride + j]};
        store(column.x * axes[0] + column.y * axes[1] + column.z * axes[2], turned[j]);
    }
    CDPR_UNROLL
    for (int i = 0; i < 3; i++)
        store(turned[0][i] * axes[0] + turned[1][i] * axes[1] + turned[2][i] * axes[2], B + stride * i);
}

// Write the inverse mass matrix of a guided platform, or of one with the masses (m), kg, of drums along the cables.
template <class T>
inline void invert_mass_matrix(const FilteredPlatform<T>& p, Quaternion<T> q, const T* mass, T (*inverse)[6]) {
    PlatformDynamics<T> body;
    body.write_mass_matrix({p.inertial}, q, Inertial<T>{p.inertial}.lever(q), p.free);
    for (int64_t i = 0; i < p.m; i++) {
        const Truth<T> heavy = mass[i] != T(0.0);
        if (!any(heavy)) continue;
        for (int j = 0; j < 6; j++) {
            for (int k = 0; k <= j; k++) {
                T& own = body.mass_matrix[6 * j + k];
                const T more = mass[i] * p.matrix[j * p.m + i] * p.free[j] * p.matrix[k * p.m + i] * p.free[k];
                own = select(heavy, own + more, own);
            }
        }
    }
    const Matrix<T> M = {body.mass_matrix, 6};
    const Truth<T> regular = factorise(M, 6, T(0.0));
    for (int k = 0; k < 6; k++) {
        T unit[6], column[6] = {};
        for (int j = 0; j < 6; j++) unit[j] = j == k ? 1.0 : 0.0;
        if (any(regular)) solve(M, unit, column, 6);
        for (int j = 0; j < 6; j++) inverse[j][k] = select(regular, column[j] * p.free[j] * p.free[k], T(NOT_A_NUMBER));
    }
}

// Write the stiffness (6, 6), by position and rotation vector, world axes, of cables with these tensions, N, and of the
// weight, which acts at r. With tau = t / l and b from the platform's origin to the anchor it is -tau (J^T J - w w^T),
// J = [1, -[b]x], and the moment (phi x b) x t u of a rotation phi.
template <class T> inline void write_stiffness(const FilteredPlatform<T>& p, const T* tension, Quaternion<T> q,
                                               Vector<T> r, Vector<T> weight, T (*stiffness)[6]) {
    constexpr int COLUMNS = Strip<T>::COLUMNS, WIDE = 8;
    const int64_t m = p.m;
    T total = 0.0, along[6][WIDE] = {}, levers[3][WIDE] = {};  // levers: sums of b times t u, tau b and tau
    for (int64_t i = 0; i < m; i++) {
        const Vector<T> b = rotate(q, vector(p.lines + i * p.w + Line<T>::PLATFORM));
        const T t = tension[i], tau = t / p.length[i], anchor[3] = {b.x, b.y, b.z};
        T w[WIDE] = {};
        CDPR_UNROLL
        for (int j = 0; j < 6; j++) w[j] = p.matrix[j * m + i];
        const T terms[WIDE] = {t * w[0], t * w[1], t * w[2], tau * b.x, tau * b.y, tau * b.z, tau, 0.0};
        CDPR_UNROLL
        for (int j = 0; j < 6; j++) {
            const T scaled = tau * w[j];
            CDPR_UNROLL
            for (int k = 0; k <= j; k += COLUMNS) store(strip(along[j] + k) + scaled * strip(w + k), along[j] + k);
        }
        CDPR_UNROLL
        for (int j = 0; j < 3; j++) {
            CDPR_UNROLL
            for (int k = 0; k < 7; k += COLUMNS)
                store(strip(levers[j] + k) + anchor[j] * strip(terms + k), levers[j] + k);
        }
        total += tau;
    }
    const T lever[3] = {r.x, r.y, r.z}, pull[3] = {weight.x, weight.y, weight.z};
    T square = 0.0, straight = dot(r, weight);
    for (int j = 0; j < 3; j++) square += levers[j][3 + j], straight += levers[j][j];
    for (int j = 0; j < 6; j++)
        for (int k = 0; k <= j; k++) stiffness[j][k] = stiffness[k][j] = along[j][k];
    for (int j = 0; j < 3; j++) {
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        const T first = levers[j][6];
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
template <class T> CDPR_INLINE bool has_stretch_state(ChainRow<T> chain) {
    return chain.stretches() && span_states(chain.span_kind()) == 0;
}

constexpr double SPEED_STEP = 1e-3;  // rad/s, of numerical derivatives: far below speeds at which friction bends

// Return the friction of a winch that moves with its cable, N s/m: the mean slope of the tension over rates with this
// standard deviation, m/s, for Coulomb friction bends within it. Differences over sqrt(3) deviations: Norgaard,
// Poulsen, Ravn, New developments in state estimation for nonlinear systems, Automatica 36 (2000), section 3.
template <class T> CDPR_INLINE T friction_slope(ChainRow<T> chain, T command, T length, T rate, T deviation) {
    const T own[MOST_STATES] = {}, zero = 0.0, least = T(SPEED_STEP) * chain.per_turn(length);
    const Truth<T> turns = least > zero;  // elsewhere there is no drum
    if (!any(turns)) return zero;
    const T step = hypotenuse(least, T(square_root(3.0)) * deviation);
    const T high = chain.held(own, command, length, rate + step, zero).tension;
    const T low = chain.held(own, command, length, rate - step, zero).tension;
    return select(turns, larger((high - low) / (T(2.0) * step), zero), zero);
}

// Return the standard deviation of the rate of cable i, m/s, with this covariance (12, 12) of the error state.
template <class T> CDPR_INLINE T rate_deviation(const FilteredPlatform<T>& p, const T* covariance, int64_t i) {
    const T* const P = covariance + (ERRORS + 1) * VELOCITY_ERROR;
    T total = 0.0;
    for (int j = 0; j < 6; j++)
        for (int k = 0; k < 6; k++) total += p.matrix[j * p.m + i] * P[ERRORS * j + k] * p.matrix[k * p.m + i];
    return square_root(larger(total, T(0.0)));
}

// Return whether a drum with a state of its own determines the tension of a cable.
template <class T> CDPR_INLINE bool on_drum(const FilteredPlatform<T>& p, ChainRow<T> chain) {
    return p.drums && has_stretch_state(chain);
}

// Rows of `matrix_rate` (m) that hold, after the use of W', a mass along each cable for the errors, kg, and the
// friction of its winch, N s/m.
template <class T> CDPR_INLINE T* masses_of_errors(const FilteredPlatform<T>& p) { return p.matrix_rate; }
template <class T> CDPR_INLINE T* friction_of_errors(const FilteredPlatform<T>& p) { return p.matrix_rate + p.m; }

// Write the inverse mass matrix; replace the commands of winches that move with their cables, N, by the tensions at a
// platform without acceleration. Errors move drums at once, with an implicit step of the friction.
template <class T> inline void write_inverse(const FilteredPlatform<T>& p, Truth<T> driven, const T* state,
                                             const T* covariance, const Vector<T>* axes, T* tension,
                                             LinearisedMotion<T>& now) {
    now.rubs = false;
    if (p.rotates) {
        const int blocks[3] = {0, 3, 21};  // of the upper half
        for (const int place : blocks) rotate_block(axes, p.inverse + place, 6, &now.inverse[0][0] + place);
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) now.inverse[3 + k][j] = now.inverse[j][3 + k];
        return;
    }
    const T zero = 0.0;
    const bool moves = any(driven) && !p.noisy;
    MatrixRate<T> moving = {p.lines, state, p.matrix_rate, p.m, p.w};
    if (moves) matrix_rate(moving);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<T> chain = chain_row(p.chains, i);
        const bool turns = on_drum(p, chain);
        T mass = 0.0, slope = 0.0;
        if (moves) {
            const T own[MOST_STATES] = {};
            const T later =  // the acceleration of the length
                difference(zero, 0, 6, [&](int64_t j) { return p.matrix_rate[j * p.m + i] * state[7 + j]; });
            const WinchTension<T> found = chain.held(own, tension[i], p.length[i], p.rate[i], later);
            const T deviation = rate_deviation(p, covariance, i);
            slope = select(driven, friction_slope(chain, tension[i], p.length[i], p.rate[i], deviation), zero);
            if (!turns) tension[i] = select(driven, found.tension, tension[i]);
            mass = select(driven, found.mass, zero);
        }
        p.rate[i] = turns ? zero : mass;
        masses_of_errors(p)[i] = mass + T(p.period) * slope;
        friction_of_errors(p)[i] = slope;
        now.rubs = now.rubs | (slope > zero);
    }
    invert_mass_matrix(p, quaternion(state + 3), p.rate, now.inverse);
}

// Write the wrench (6) that accelerates the platform, and its derivatives, without those of the inertia by the
// attitude, which are of second order.
template <class T> inline void write_wrench(const FilteredPlatform<T>& p, const T* state, const Vector<T>* axes,
                                            const T* tension, T* wrench, LinearisedMotion<T>& now) {
    const Inertial<T> body = {p.inertial};
    const Quaternion<T> q = quaternion(state + 3);
    const Vector<T> spin = vector(state + 10), r = body.lever(q), turning = cross(spin, r);
    T stiffness[6][6], inertia[9];
    rotate_block(axes, p.inertial + Inertial<T>::INERTIA, 3, inertia);
    const Vector<T> momentum = product(inertia, spin);
    // at zero accelerations; the derivatives need the inertia in world axes, too
    store(inverse_dynamics(body.mass(), vector(p.gravity), r, cross(spin, turning), cross(spin, momentum)), wrench);
    for (int j = 0; j < 6; j++) {
        const T* row = p.matrix + j * p.m;
        wrench[j] = sum(-wrench[j], 0, p.m, [&](int64_t i) { return row[i] * tension[i]; });
    }
    write_stiffness(p, tension, q, r, body.mass() * vector(p.gravity), stiffness);
    for (int j = 0; j < 6; j++) {
        T* const row = now.wrench_rate[j];
        for (int k = 0; k < 3; k++) {
            row[k] = stiffness[j][k];
            row[TURN_ERROR + k] = dot(vector(stiffness[j] + 3), axes[k]);
            row[VELOCITY_ERROR + k] = 0.0;
        }
    }
    CDPR_UNROLL
    for (int k = 0; k < 3; k++) {  // an angular velocity e more along axis k
        const Vector<T> force = -body.mass() * (unit_cross(k, turning) + cross(spin, unit_cross(k, r)));
        const Vector<T> gyroscopic = unit_cross(k, momentum) + cross(spin, vector(inertia + 3 * k));
        const Vector<T> moment = cross(r, force) - gyroscopic;
        const T column[6] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
        for (int j = 0; j < 6; j++) now.wrench_rate[j][SPIN_ERROR + k] = column[j];
    }
    for (int64_t i = 0; any(now.rubs) && i < p.m; i++) {
        const T slope = friction_of_errors(p)[i];
        for (int j = 0; j < 6; j++) {
            for (int k = 0; k < 6; k++) {
                T& own = now.wrench_rate[j][VELOCITY_ERROR + k];
                own = select(now.rubs, own - slope * p.matrix[j * p.m + i] * p.matrix[k * p.m + i], own);
            }
        }
    }
}

// Write the accelerations at a state with these tensions, N, and the derivatives of the wrench.
template <class T> inline void linearise_motion(const FilteredPlatform<T>& p, Truth<T> driven, const T* state,
                                                const T* covariance, const Vector<T>* axes, T* tension,
                                                LinearisedMotion<T>& now) {
    Geometry<T> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    write_inverse(p, driven, state, covariance, axes, tension, now);
    const T zero = 0.0;
    T wrench[6] = {};
    if (any(driven)) write_wrench(p, state, axes, tension, wrench, now);
    for (int j = 0; j < 6 && !all(driven); j++) {
        wrench[j] = select(driven, wrench[j], zero);
        for (int k = 0; k < ERRORS; k++)
            now.wrench_rate[j][k] = any(driven) ? select(driven, now.wrench_rate[j][k], zero) : zero;
    }
    for (int j = 0; j < 6; j++)
        now.acceleration[j] = sum(zero, 0, 6, [&](int64_t k) { return now.inverse[j][k] * wrench[k]; });
    const Truth<T> moving = driven & (now.rubs | Truth<T>(p.drums && !p.rotates));
    if (!any(moving)) return;
    T inverse[6][6];
    invert_mass_matrix(p, quaternion(state + 3), masses_of_errors(p), inverse);
    for (int j = 0; j < 6; j++)
        for (int k = 0; k < 6; k++) now.inverse[j][k] = select(moving, inverse[j][k], now.inverse[j][k]);
}

// Advance state (13) and covariance (12, 12) by a control period under these tensions (m), N, which are overwritten:
// by the explicit midpoint rule.
template <class T> inline void predict(const FilteredPlatform<T>& p, const T* before, const T* covariance, T* tension,
                                       const TensionErrors<T>& errors, T* after, T* predicted) {
    const T h = p.period, half = 0.5 * p.period, quarter = 0.5 * p.period * p.period;
    const Truth<T> driven = Truth<T>(p.driven != 0) & (tension[0] == tension[0]);
    const Vector<T> velocity = vector(before + 7), spin = vector(before + 10);
    T middle[13];
    store(vector(before) + half * velocity, middle);
    store(multiply(exponential(half * spin), quaternion(before + 3)), middle + 3);
    for (int j = 7; j < 13; j++) middle[j] = before[j];
    const Quaternion<T> q = quaternion(middle + 3);
    const Vector<T> axes[3] = {rotate(q, unit_vector<T>(0)), rotate(q, unit_vector<T>(1)),
                               rotate(q, unit_vector<T>(2))};
    LinearisedMotion<T> now;
    linearise_motion(p, driven, middle, covariance, axes, tension, now);
    ErrorMotion<T> step;
    write_error_motion(p, driven, axes, now, step);
    T* const a = now.acceleration;
    T later[6];  // with the angular velocity of the middle, too
    for (int j = 0; j < 6; j++)
        later[j] = a[j] + 0.5 * sum(T(0.0), 0, 3, [&](int64_t k) { return step.change[j][SPIN_ERROR + k] * a[3 + k]; });
    const Vector<T> linear = vector(later), angular = vector(later + 3);
    store(vector(before) + h * velocity + quarter * linear, after);
    store(multiply(exponential(h * spin + quarter * angular), quaternion(before + 3)), after + 3);
    store(velocity + h * linear, after + 7);
    store(spin + h * angular, after + 10);
    predict_covariance(step, axes, h, covariance, predicted);
    if (p.noisy) spread_by_tensions(p, driven, now, step, axes, errors, predicted);
}

}  // namespace cdpr::CDPR_TARGET
