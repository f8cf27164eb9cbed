// Covariance of an error-state Kalman filter in a prediction: ekf_covariance.py. SPDX-License-Identifier: Apache-2.0
//
// Error state (12): position, m, world axes; attitude e, rad, platform axes, q = q_estimate exp(e); velocity, m/s, and
// angular velocity, rad/s, world axes (Sola (2017), "Quaternion kinematics for the error-state Kalman filter", section
// 5, but with the world's axes for the angular velocity, so that e' = R^T d omega has no further term).
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/strip.hpp>
#include <cdpr/sum.hpp>
#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int ERRORS = 12;
enum ErrorState { PLACE_ERROR = 0, TURN_ERROR = 3, VELOCITY_ERROR = 6, SPIN_ERROR = 9 };

// Nominal robot, as far as it moves the platform.
template <class T> struct FilteredPlatform {
    const T* lines;     // (m, w), as in Geometry
    const T* chains;    // (m, 33), chain.hpp
    const T* inertial;  // (13), `Robot.inertial`
    const T* inverse;   // (6, 6), inverse mass matrix about the platform's origin, platform axes
    const T* gravity;   // (3), m/s^2, world
    const T* free;      // (6), 1 for each free row of a twist, 0 for directions blocked by a guide
    const T* noise;     // (2, 2), white force, N^2 s, and moment, (N m)^2 s, about the platform's origin: with
                        // known tensions, and without
    const T* cells;     // (m), N, standard deviation of the measured tensions
    T* matrix;          // (6, m), work space: W
    T* length;          // (m), work space, m
    T* rate;            // (m), work space, m/s
    T* matrix_rate;     // (6, m), work space: W'
    T* forces;          // (m), work space, N
    double period;      // s, of control
    int64_t driven;     // 1: forced by tensions; 0: unknown tensions balance the weight
    int64_t rotates;    // 1: `inverse` applies; 0: guided, or drums with inertia, so M is factorised at each step
    int64_t elastic;    // 1: a cable stretches
    int64_t drums;      // 1: drums of cables that stretch have states; 0: they follow their cables at once
    int64_t noisy;      // 1: tensions are measured, with the errors `cells`; NaN until the first measurement
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), chains(m, 33), inertial(13), inverse(6, 6), gravity(3), free(6), noise(2, 2), cells(m), "
        "work matrix(6, m), work length(m), work rate(m), work matrix_rate(6, m), work forces(m), period, driven, "
        "rotates, elastic, drums, noisy, m, w";
};

// Dynamics at a state.
template <class T> struct LinearisedMotion {
    T inverse[6][6];           // of the mass matrix; 0 in blocked directions
    T wrench_rate[6][ERRORS];  // derivatives of the wrench by the error state
    T acceleration[6];         // linear and angular
    Truth<T> rubs;             // the wrench depends on the velocities by friction of winches
};

// Change of the velocity errors in a step, per error state, and covariance of its noise with the error state.
template <class T> struct ErrorMotion {
    T change[6][ERRORS];
    T noise[6][ERRORS];
    Truth<T> rubs;
};

// Write the sum of six rows with these weights.
template <class T> CDPR_INLINE void write_weighted(const T* weights, const T (*rows)[ERRORS], T* total) {
    for (int k = 0; k < ERRORS; k += Strip<T>::COLUMNS) {
        auto part = weights[0] * strip(rows[0] + k);
        CDPR_UNROLL
        for (int i = 1; i < 6; i++) part = part + weights[i] * strip(rows[i] + k);
        store(part, total + k);
    }
}

// Write them; the noise acts on positions by half a step.
template <class T> inline void write_error_motion(const FilteredPlatform<T>& p, Truth<T> driven, const Vector<T>* axes,
                                                  const LinearisedMotion<T>& now, ErrorMotion<T>& step) {
    const T h = p.period, half = 0.5 * p.period;
    step.rubs = now.rubs;
    T effects[6][ERRORS];
    for (int i = 0; i < 6; i++) {
        const T* const row = now.inverse[i];  // the effects of a wrench: the matrix is symmetric
        const Vector<T> linear = vector(row), angular = vector(row + 3);
        store(half * linear, effects[i]);
        for (int k = 0; k < 3; k++) effects[i][TURN_ERROR + k] = half * dot(angular, axes[k]);
        store(linear, effects[i] + VELOCITY_ERROR);
        store(angular, effects[i] + SPIN_ERROR);
    }
    for (int j = 0; j < 6; j++) {
        T scaled[6], spread[6];
        for (int i = 0; i < 6; i++) {
            scaled[i] = h * now.inverse[j][i];
            spread[i] = scaled[i] * select(driven, p.noise[i / 3], p.noise[2 + i / 3]);
        }
        write_weighted(scaled, now.wrench_rate, step.change[j]);
        write_weighted(spread, effects, step.noise[j]);
    }
}

// Write Y = F X + G noise for columns of X (12, 12), the first of which is `column`; without noise Y = F X.
template <bool noisy, class T, class Columns> CDPR_INLINE void transition(const Columns* X, const ErrorMotion<T>& step,
                                                                          const Vector<T>* axes, T h, int column,
                                                                          Columns* Y) {
    CDPR_UNROLL
    for (int j = 0; j < 6; j++) {
        Columns row = X[VELOCITY_ERROR + j];
        if constexpr (noisy) row = row + strip(step.noise[j] + column);
        CDPR_UNROLL
        for (int i = 0; i < VELOCITY_ERROR; i++) row = row + step.change[j][i] * X[i];
        if (any(step.rubs)) {
            Columns rubbed = row;
            for (int i = VELOCITY_ERROR; i < SPIN_ERROR; i++) rubbed = rubbed + step.change[j][i] * X[i];
            row = select(step.rubs, rubbed, row);
        }
        CDPR_UNROLL
        for (int i = SPIN_ERROR; i < ERRORS; i++) row = row + step.change[j][i] * X[i];
        Y[VELOCITY_ERROR + j] = row;
    }
    Columns turns[3];
    const T half = T(0.5) * h;
    CDPR_UNROLL
    for (int j = 0; j < 3; j++) {
        Y[j] = X[j] + half * (X[VELOCITY_ERROR + j] + Y[VELOCITY_ERROR + j]);
        turns[j] = half * (X[SPIN_ERROR + j] + Y[SPIN_ERROR + j]);
    }
    CDPR_UNROLL
    for (int j = 0; j < 3; j++)
        Y[TURN_ERROR + j] = X[TURN_ERROR + j] + axes[j].x * turns[0] + axes[j].y * turns[1] + axes[j].z * turns[2];
}

// Copy the upper half of a covariance (12, 12) to the lower one.
template <class T> CDPR_INLINE void mirror(T* covariance) {
    for (int j = 1; j < ERRORS; j++)
        for (int k = 0; k < j; k++) covariance[ERRORS * j + k] = covariance[ERRORS * k + j];
}

// Write the predicted covariance (12, 12), which may be the given one: F (F P)^T + G noise.
template <class T> inline void predict_covariance(const ErrorMotion<T>& step, const Vector<T>* axes, T h,
                                                  const T* covariance, T* predicted) {
    typedef typename Strip<T>::type Columns;
    Columns X[ERRORS], Y[ERRORS];
    T rows[ERRORS][ERRORS];
    for (int k = 0; k < ERRORS; k += Strip<T>::COLUMNS) {
        for (int j = 0; j < ERRORS; j++) X[j] = strip(covariance + ERRORS * j + k);
        transition<false>(X, step, axes, h, k, Y);
        for (int j = 0; j < ERRORS; j++) store(Y[j], rows[j] + k);
    }
    for (int k = 0; k < ERRORS; k += Strip<T>::COLUMNS) {
        for (int j = 0; j < ERRORS; j++) X[j] = strip_of_column(rows[k] + j, ERRORS);
        transition<true>(X, step, axes, h, k, Y);
        for (int j = 0; j < ERRORS; j++) store(Y[j], predicted + ERRORS * j + k);
    }
    mirror(predicted);
}

}  // namespace cdpr::CDPR_TARGET
