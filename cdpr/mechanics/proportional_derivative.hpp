// Errors of pose and velocity, and their proportional and damping terms. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

// Accelerations, m/s^2 and rad/s^2, world axes.
template <class T> struct Feedback {
    Vector<T> linear, angular;
};

// Rotation vector, rad, from the actual to the desired attitude; both arrays begin with a pose (7).
template <class T> CDPR_INLINE Vector<T> attitude_error(const T* state, const T* desired) {
    return logarithm(multiply(quaternion(desired + 3), conjugate(quaternion(state + 3))));
}

template <class T> CDPR_INLINE Vector<T> each_times(Vector<T> a, Vector<T> b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

// Return kp (x_d - x) + kd (v_d - v), linear and angular; `gains` (12): kp (6), 1/s^2, and kd (6), 1/s. `state` (13)
// and `desired` (13 or more): position, quaternion, velocity, angular velocity. `turn`: attitude_error of both.
template <class T>
CDPR_INLINE Feedback<T> proportional_derivative(const T* state, const T* desired, const T* gains, Vector<T> turn) {
    const T *kp = gains, *kd = gains + 6;
    const Vector<T> offset = vector(desired) - vector(state), slip = vector(desired + 7) - vector(state + 7);
    const Vector<T> spin = vector(desired + 10) - vector(state + 10);
    return {each_times(vector(kp), offset) + each_times(vector(kd), slip),
            each_times(vector(kp + 3), turn) + each_times(vector(kd + 3), spin)};
}

template <class T> CDPR_INLINE Feedback<T> proportional_derivative(const T* state, const T* desired, const T* gains) {
    return proportional_derivative(state, desired, gains, attitude_error(state, desired));
}

}  // namespace cdpr::CDPR_TARGET
