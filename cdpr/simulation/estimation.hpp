// Operations about the estimate of the state: cdpr/simulation/estimation.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/status.hpp>
#include <cdpr/strip.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Arrival {
    const T* age;   // (1), s, time since the held measurement was taken
    const T* time;  // (1), s
    T* before;      // (1), s, the age at the previous control step
    T* fresh;       // (1), 1 if a new measurement has arrived, else 0
    double step;    // s, control period
    static constexpr char fields[] = "age(1), time(1), both before(1), fresh(1), step";
};

// Report whether a measurement has arrived: that which is held ages by one control period.
template <class T> inline int arrived(Arrival<T>& p) {
    const Truth<T> newer = (!(*p.time > T(0.0))) | (*p.age < *p.before + T(0.5 * p.step));
    *p.fresh = select(newer, T(1.0), T(0.0));
    *p.before = *p.age;
    return 0;
}

template <class T> struct EstimateStart {
    const T* state;  // (13), true state
    const T* given;  // (7), position, m, and quaternion that the estimator assumes; NaN: the true ones
    const T* time;   // (1), s
    T* start;        // (13)
    static constexpr char fields[] = "state(13), given(7), time(1), both start(13)";
};

// Write at time 0 the state from which the estimate begins.
template <class T> inline int start_estimate(EstimateStart<T>& p) {
    const Truth<T> begins = !(*p.time > T(0.0));
    if (!any(begins)) return 0;
    for (int i = 0; i < 13; i++) {
        const T begin = i < 7 ? select(p.given[i] == p.given[i], p.given[i], p.state[i]) : p.state[i];
        p.start[i] = select(begins, begin, p.start[i]);
    }
    return 0;
}

template <class T> struct EstimatedAttitude {
    const T* estimate;  // (13)
    static constexpr char fields[] = "estimate(13)";
};

// Largest difference of a squared norm from 1: far above round-off.
constexpr double NOT_UNIT = 1e-6;

// Return BAD_INPUT if the quaternion of an estimate is finite, but has not the norm 1.
template <class T> inline int not_unit(EstimatedAttitude<T>& p) {
    const T* const q = p.estimate + 3;
    const T apart = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - T(1.0);
    return code(select(absolute(apart) > T(NOT_UNIT), T(double(BAD_INPUT)), T(double(OK))));
}

template <class T> struct EstimateError {
    const T* state;       // (13), true state
    const T* estimate;    // (13)
    const T* covariance;  // (12, 12), as `Estimator.covariance`
    T* sigma;             // (12), standard deviations
    T* nees;              // (1), normalised estimation error squared; NaN if the covariance is none, or singular
    T* factor;            // (12, 12), work space
    static constexpr char fields[] =
        "state(13), estimate(13), covariance(12, 12), sigma(12), nees(1), work factor(12, 12)";
};

// Largest difference of two opposite entries of a covariance, as a share of the standard deviations: round-off.
constexpr double ASYMMETRY = 1e-9;

// Write standard deviations and e^T P^-1 e of the errors that have a variance: Bar-Shalom, Li, Kirubarajan, Estimation
// with Applications to Tracking and Navigation (2001), eq. 5.4.2-2.
template <class T> inline int judge_estimate(EstimateError<T>& p) {
    constexpr int COLUMNS = Strip<T>::COLUMNS;
    const T zero = 0.0, one = 1.0;
    T error[12];
    const Quaternion<T> q = multiply(conjugate(quaternion(p.estimate + 3)), quaternion(p.state + 3));
    store(logarithm(q), error + 3);
    for (int i = 0; i < 3; i++) error[i] = p.state[i] - p.estimate[i];
    for (int i = 6; i < 12; i++) error[i] = p.state[1 + i] - p.estimate[1 + i];
    for (int i = 0; i < 12; i++) p.sigma[i] = square_root(larger(p.covariance[13 * i], zero));
    // Eliminate one error after the other, by L D L^T; of `factor` only the upper half has a meaning.
    for (int i = 0; i < 144; i += COLUMNS) store(strip(p.covariance + i), p.factor + i);
    T squares = 0.0;
    Truth<T> some = false, regular = true;
    for (int k = 0; k < 12; k++) {
        const T variance = p.covariance[13 * k], left = p.factor[13 * k];
        for (int i = k; i < 12; i++) {
            const T apart = p.covariance[12 * i + k] - p.covariance[12 * k + i];
            const T most = T(ASYMMETRY * ASYMMETRY) * variance * p.covariance[13 * i];
            regular = regular & (variance >= zero) & (apart * apart <= most);
        }
        const Truth<T> varies = variance > zero;
        if (!any(varies)) continue;
        some = some | varies;
        regular = regular & ((!varies) | (left > SINGULAR * variance));
        const T inverse = one / left, part = error[k] * inverse;
        squares = select(varies, squares + error[k] * part, squares);
        const T* const row = p.factor + 12 * k;
        for (int i = k + 1; i < 12; i++) {
            const T share = row[i] * inverse;
            for (int j = i - i % COLUMNS; j < 12; j += COLUMNS) {
                T* const own = p.factor + 12 * i + j;
                store(select(varies, strip(own) - share * strip(row + j), strip(own)), own);
            }
            error[i] = select(varies, error[i] - row[i] * part, error[i]);
        }
    }
    *p.nees = select(some & regular, squares, T(NOT_A_NUMBER));
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
