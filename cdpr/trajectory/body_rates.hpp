// Angular velocity and acceleration of an attitude given by a rotation vector. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

// Below this angle, rad, the coefficients are series, with a truncation error below 1e-14; as in
// cdpr.trajectory.rotation_rates.
constexpr double SMALL_ANGLE = 0.05;

// Coefficients of the right Jacobian J = 1 - a [phi] + b [phi]^2, a = (1 - cos t) / t^2, b = (t - sin t) / t^3, t =
// |phi|, and of its derivative by time: a' / (t t') and b' / (t t'). Chirikjian (2012), section 10.6.
struct JacobianCoefficients {
    double a, b, da, db;
};

inline JacobianCoefficients jacobian_coefficients(double square) {
    const double t = square_root(square);
    if (t < SMALL_ANGLE) {
        const double cube = square * (square * square);
        return {0.5 - square / 24.0 + square * square / 720.0 - cube / 40320.0,
                1.0 / 6.0 - square / 120.0 + square * square / 5040.0 - cube / 362880.0,
                -1.0 / 12.0 + square / 180.0 - square * square / 6720.0,
                -1.0 / 60.0 + square / 1260.0 - square * square / 60480.0};
    }
    const double s = sine(t), c = cosine(t);
    return {(1.0 - c) / square, (t - s) / (square * t), (t * s - 2.0 * (1.0 - c)) / (square * square),
            (3.0 * s - 2.0 * t - t * c) / (square * square * t)};
}

struct BodyRates {
    Vector<double> omega;  // rad/s, body axes
    Vector<double> alpha;  // rad/s^2, body axes
};

// Rates of R = exp(phi): omega = J phi', alpha = J phi'' + J' phi'; phi in rad, `rate` and `second` its derivatives.
inline BodyRates body_rates(Vector<double> phi, Vector<double> rate, Vector<double> second) {
    const auto [a, b, da, db] = jacobian_coefficients(dot(phi, phi));
    const double growth = dot(phi, rate);
    const Vector<double> c1 = cross(phi, rate), c2 = cross(phi, c1);
    const Vector<double> d1 = cross(phi, second), d2 = cross(phi, d1);
    const Vector<double> e = cross(rate, c1);
    return {rate - a * c1 + b * c2, second - a * d1 + b * d2 - da * growth * c1 + db * growth * c2 + b * e};
}

}  // namespace cdpr::CDPR_TARGET
