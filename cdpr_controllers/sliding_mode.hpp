// Sliding-mode control in task space: cdpr_controllers/sliding_mode.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/proportional_derivative.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct SlidingModeControl {
    const T* gains;     // (3, 2): slope, 1/s; gain, m/s^2, rad/s^2; layer, m/s, rad/s; of position and attitude
    const T* inertial;  // (13), `Robot.inertial`
    const T* gravity;   // (3), m/s^2, world
    const T* state;     // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    const T* desired;   // (19): the same, acceleration, m/s^2, and angular acceleration, rad/s^2
    T* surface;         // (3), m/s: the sliding variable
    T* spin_surface;    // (3), rad/s: the same of the attitude
    T* wrench;          // (6), N and N m, about the platform's origin
    static constexpr char fields[] =
        "gains(3, 2), inertial(13), gravity(3), state(13), desired(19), surface(3), "
        "spin_surface(3), wrench(6)";
};

// Return the acceleration towards the surface, and write the sliding variable s = rate + slope * error. Within the
// boundary layer, |s| < layer, the acceleration is proportional to s.
template <class T> CDPR_INLINE Vector<T> towards_surface(const T* gains, Vector<T> error, Vector<T> rate, T* surface) {
    const T slope = gains[0], gain = gains[2], layer = gains[4];
    const Vector<T> s = rate + slope * error;
    store(s, surface);
    return slope * rate + (gain / larger(length(s), layer)) * s;
}

template <class T> inline int sliding_mode(SlidingModeControl<T>& control) {
    const T *state = control.state, *desired = control.desired, *gains = control.gains;
    const Vector<T> offset = vector(desired) - vector(state), slip = vector(desired + 7) - vector(state + 7);
    const Vector<T> turn = attitude_error(state, desired), spin = vector(desired + 10) - vector(state + 10);
    const Vector<T> a = vector(desired + 13) + towards_surface(gains, offset, slip, control.surface);
    const Vector<T> alpha = vector(desired + 16) + towards_surface(gains + 1, turn, spin, control.spin_surface);
    store(inverse_dynamics<T>({control.inertial}, vector(control.gravity), quaternion(state + 3), vector(state + 10), a,
                              alpha),
          control.wrench);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
