// Operations about the estimate of the state: cdpr/simulation/estimation.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/status.hpp>
#include <cdpr/twelve.hpp>

namespace cdpr::CDPR_TARGET {

struct Arrival {
    const double* age;  // (1), s, time since the held measurement was taken
    double* before;     // (1), s, the same at the previous control step
    double* fresh;      // (1), 1 if a new measurement has arrived, else 0
    double step;        // s, control period
    static constexpr char fields[] = "age(1), both before(1), fresh(1), step";
};

// Report whether a measurement has arrived: that which is held ages by one control period.
inline int arrived(Arrival& p, double time) {
    *p.fresh = !(time > 0.0) || *p.age < *p.before + 0.5 * p.step ? 1.0 : 0.0;
    *p.before = *p.age;
    return 0;
}

struct EstimateStart {
    const double* state;  // (13), true state
    const double* given;  // (7), position, m, and quaternion that the estimator assumes; NaN: the true ones
    double* time;         // (1), s
    double* start;        // (13)
    static constexpr char fields[] = "state(13), given(7), time(1), both start(13)";
};

// Write the time, and at time 0 the state from which the estimate begins.
inline int start_estimate(EstimateStart& p, double time) {
    *p.time = time;
    for (int i = 0; i < 13 && !(time > 0.0); i++)
        p.start[i] = i < 7 && p.given[i] == p.given[i] ? p.given[i] : p.state[i];
    return 0;
}

struct EstimatedAttitude {
    const double* estimate;  // (13)
    static constexpr char fields[] = "estimate(13)";
};

// Largest difference of a squared norm from 1: far above round-off.
constexpr double NOT_UNIT = 1e-6;

// Return BAD_INPUT if the quaternion of an estimate is finite, but has not the norm 1.
inline int not_unit(EstimatedAttitude& p) {
    const double* const q = p.estimate + 3;
    const double apart = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0;
    return apart > NOT_UNIT || apart < -NOT_UNIT ? int(BAD_INPUT) : 0;
}

struct EstimateError {
    const double* state;       // (13), true state
    const double* estimate;    // (13)
    const double* covariance;  // (12, 12), as `Estimator.covariance`
    double* sigma;             // (12), standard deviations
    double* nees;              // (1), normalised estimation error squared; NaN if the covariance is none, or singular
    double* factor;            // (12, 12), work space
    static constexpr char fields[] =
        "state(13), estimate(13), covariance(12, 12), sigma(12), nees(1), work factor(12, 12)";
};

// Largest difference of two opposite entries of a covariance, as a share of the standard deviations: round-off.
constexpr double ASYMMETRY = 1e-9;

// Write standard deviations and e^T P^-1 e of the errors that have a variance: Bar-Shalom, Li, Kirubarajan, Estimation
// with Applications to Tracking and Navigation (2001), eq. 5.4.2-2.
inline int judge_estimate(EstimateError& p) {
    double error[12];
    const Quaternion<double> q = multiply(conjugate(quaternion(p.estimate + 3)), quaternion(p.state + 3));
    store(logarithm(q), error + 3);
    for (int i = 0; i < 3; i++) error[i] = p.state[i] - p.estimate[i];
    for (int i = 6; i < 12; i++) error[i] = p.state[1 + i] - p.estimate[1 + i];
    for (int i = 0; i < 12; i++) {
        p.sigma[i] = square_root(larger(p.covariance[13 * i], 0.0));
        store(twelve(p.covariance + 12 * i), p.factor + 12 * i);
    }
    double squares = 0.0;
    bool some = false, regular = true;
    for (int k = 0; k < 12 && regular; k++) {  // eliminate one error after the other: L D L^T
        const double variance = p.covariance[13 * k], left = p.factor[13 * k];
        for (int i = k; i < 12; i++) {
            const double apart = p.covariance[12 * i + k] - p.covariance[12 * k + i];
            const double most = ASYMMETRY * ASYMMETRY * variance * p.covariance[13 * i];
            regular = regular && variance >= 0.0 && apart * apart <= most;
        }
        if (!(variance > 0.0)) continue;
        some = true;
        regular = regular && left > SINGULAR * variance;
        const double inverse = 1.0 / left;
        squares += error[k] * error[k] * inverse;
        const Twelve row = twelve(p.factor + 12 * k);
        for (int i = k + 1; i < 12; i++) {
            const double share = p.factor[12 * i + k] * inverse;
            store(twelve(p.factor + 12 * i) - share * row, p.factor + 12 * i);
            error[i] -= share * error[k];
        }
    }
    *p.nees = some && regular ? squares : NOT_A_NUMBER;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
