// Errors of measured tensions in an error-state Kalman filter: ekf_tension_errors.py. SPDX-License-Identifier:
// Apache-2.0
#pragma once

#include <cdpr_controllers/estimators/ekf_covariance.hpp>

namespace cdpr::CDPR_TARGET {

// Further error states of the filter: of each cable in turn the errors of the stretch, m, and of the tension, N.
template <class T> struct TensionErrors {
    T* kept;        // (stored()): estimates of the errors of the tensions (m), N; covariances (2 m, 12) with the error
                    // state of the platform; covariance (2 m, 2 m)
    T* terms;       // (20, m), work space
    int64_t m = 0;  // 0 without load cells
    T keeps = 0.0;  // share of the tension's error that remains after a period: 1 if it is held, 0 if it is new

    CDPR_INLINE int64_t stored() const { return m + 2 * m * ERRORS + 4 * m * m; }
    CDPR_INLINE T& estimate(int64_t i) const { return kept[i]; }
    CDPR_INLINE T* with_platform(int64_t j) const { return kept + m + ERRORS * j; }
    CDPR_INLINE T* own(int64_t j) const { return kept + m + 2 * m * ERRORS + 2 * m * j; }
    CDPR_INLINE T& variance(int64_t i) const { return own(2 * i + 1)[2 * i + 1]; }  // of the tension

    // Change (12) of the platform's error state in a period by 1 N.
    CDPR_INLINE T* effect(int64_t i) const { return terms + ERRORS * i; }
    // Share of the stretch that remains after a period; stretch by 1 N at its begin, and at its end, m/N.
    CDPR_INLINE T* response(int64_t i) const { return terms + ERRORS * m + 3 * i; }
    // Variance, N^2, which a measurement, or the time since then, adds to that of the tension.
    CDPR_INLINE T& added(int64_t i) const { return terms[(ERRORS + 3) * m + i]; }
    // Corrections (2 m) that the measurements of a sensor give.
    CDPR_INLINE T* correction() const { return terms + (ERRORS + 4) * m; }

    // Add the covariance of cable i's stretch, which shortens its unwound length, to the gain; return the rest of the
    // variance of that length.
    CDPR_INLINE T add_to_gain(int64_t i, const T* row, T* gain) const {
        const T* const shared = with_platform(2 * i);
        T rest = own(2 * i)[2 * i];
        for (int j = 0; j < ERRORS; j++) {
            gain[j] = gain[j] - shared[j];
            rest = rest - row[j] * shared[j];
        }
        return rest;
    }

    // Correct after a measurement: `share` is the gain (12) by its variance, `precision` the inverse of that. Cable i:
    // the one whose unwound length was measured, negative for another value.
    inline void correct(Truth<T> where, int64_t i, const T* row, const T* share, T scaled, T precision) const {
        for (int64_t j = 0; j < 2 * m; j++) {
            const T* const shared = with_platform(j);
            T& gain = terms[(ERRORS + 6) * m + j];
            gain = i < 0 ? T(0.0) : -own(2 * i)[j];
            for (int k = 0; k < ERRORS; k++) gain = gain + row[k] * shared[k];
        }
        for (int64_t j = 0; j < 2 * m; j++) {
            T *const shared = with_platform(j), *const row_of_own = own(j);
            const T* const gain = terms + (ERRORS + 6) * m;
            const T along = gain[j], less = along * precision;
            correction()[j] = select(where, correction()[j] + along * scaled, correction()[j]);
            for (int k = 0; k < ERRORS; k++) shared[k] = select(where, shared[k] - along * share[k], shared[k]);
            for (int64_t k = 0; k < 2 * m; k++)
                row_of_own[k] = select(where, row_of_own[k] - less * gain[k], row_of_own[k]);
        }
    }
};

// Add a b^T + b a^T to a covariance (12, 12).
template <class T> CDPR_INLINE void add_symmetric(const T* a, const T* b, T* covariance) {
    for (int j = 0; j < ERRORS; j++)
        for (int k = 0; k < ERRORS; k++) covariance[ERRORS * j + k] += a[j] * b[k] + b[j] * a[k];
}

// Advance the covariances with the error state, and spread its predicted covariance (12, 12): by the mean error of a
// period, half of that at its begin and half of that at its end.
template <class T> inline void spread_by_tensions(const FilteredPlatform<T>& p, Truth<T> driven,
                                                  const LinearisedMotion<T>& now, const ErrorMotion<T>& step,
                                                  const Vector<T>* axes, const TensionErrors<T>& errors, T* predicted) {
    const T h = p.period, half = 0.5 * p.period, share = T(0.5) * (T(1.0) + errors.keeps);
    T part[ERRORS];
    for (int64_t i = 0; i < errors.m; i++) {
        T pull[6] = {}, *const effect = errors.effect(i);
        for (int j = 0; j < 6; j++) {
            for (int k = 0; k < 6; k++) pull[j] = pull[j] + h * now.inverse[j][k] * p.matrix[k * p.m + i];
            pull[j] = select(driven, pull[j], T(0.0));
            effect[VELOCITY_ERROR + j] = pull[j];
        }
        store(half * vector(pull), effect);
        for (int j = 0; j < 3; j++) effect[TURN_ERROR + j] = half * dot(axes[j], vector(pull + 3));
    }
    for (int64_t j = 0; j < 2 * errors.m; j++) {
        T before[ERRORS], *const shared = errors.with_platform(j);
        for (int k = 0; k < ERRORS; k++) before[k] = shared[k];
        transition<false>(before, step, axes, h, 0, shared);
        for (int k = 0; k < ERRORS; k++) part[k] = T(0.5) * share * shared[k];
        if (j % 2 == 1) add_symmetric(errors.effect(j / 2), part, predicted);
        for (int64_t i = 0; i < errors.m; i++) {
            const T common = share * errors.own(j)[2 * i + 1], *const effect = errors.effect(i);
            for (int k = 0; k < ERRORS; k++) shared[k] = shared[k] + common * effect[k];
        }
        if (j % 2 == 0) continue;
        const T added = T(0.125) * errors.added(j / 2), *const effect = errors.effect(j / 2);
        for (int k = 0; k < ERRORS; k++) part[k] = T(0.5) * share * shared[k] + added * effect[k];
        add_symmetric(effect, part, predicted);
    }
}

// Complete the prediction of the errors with the response of the stretch.
template <class T> inline void advance_tension_errors(Truth<T> driven, const TensionErrors<T>& errors) {
    const T keeps = errors.keeps, zero = 0.0, half = 0.5;
    const auto advance = [&](int64_t i, T& stretch, T& tension) {
        const T* const response = errors.response(i);
        stretch = select(driven, response[0] * stretch + (response[1] + keeps * response[2]) * tension, zero);
        tension = select(driven, keeps * tension, zero);
    };
    const int64_t m = errors.m;
    for (int64_t i = 0; i < m; i++) {
        T *const stretch = errors.with_platform(2 * i), *const tension = stretch + ERRORS;
        const T added = half * errors.added(i), *const effect = errors.effect(i);
        const T end = select(driven, errors.response(i)[2], zero);
        for (int k = 0; k < ERRORS; k++) {
            advance(i, stretch[k], tension[k]);
            stretch[k] = stretch[k] + end * added * effect[k];
            tension[k] = tension[k] + added * effect[k];
        }
        for (int64_t k = 0; k < 2 * m; k++) advance(i, errors.own(2 * i)[k], errors.own(2 * i + 1)[k]);
    }
    for (int64_t i = 0; i < m; i++) {
        for (int64_t j = 0; j < 2 * m; j++) advance(i, errors.own(j)[2 * i], errors.own(j)[2 * i + 1]);
        T *const stretch = errors.own(2 * i) + 2 * i, *const tension = errors.own(2 * i + 1) + 2 * i;
        const T added = select(driven, errors.added(i), zero), end = select(driven, errors.response(i)[2], zero);
        stretch[0] = stretch[0] + end * end * added;
        stretch[1] = stretch[1] + end * added;
        tension[0] = tension[0] + end * added;
        tension[1] = tension[1] + added;
    }
}

}  // namespace cdpr::CDPR_TARGET
