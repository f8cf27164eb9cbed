// Computed torque in task space (thesis 6.3 to 6.5): cdpr_controllers/computed_torque.py. SPDX-License-Identifier:
// Apache-2.0
#pragma once

#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/proportional_derivative.hpp>

namespace cdpr::CDPR_TARGET {

// Common part of the controllers computed_torque and static.
template <class T> struct TaskSpaceControl {
    const T* gains;     // (12): kp (6), 1/s^2, and kd (6), 1/s, of x, y, z, rx, ry, rz
    const T* inertial;  // (13), `Robot.inertial`
    const T* gravity;   // (3), m/s^2, world
    const T* state;     // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    const T* desired;   // (19): the same, acceleration, m/s^2, and angular acceleration, rad/s^2
    T* wrench;          // (6), N and N m, about the platform's origin
    static constexpr char fields[] = "gains(12), inertial(13), gravity(3), state(13), desired(19), wrench(6)";
};

template <class T> inline int computed_torque(TaskSpaceControl<T>& control) {
    const T *state = control.state, *desired = control.desired;
    const Feedback<T> feedback = proportional_derivative(state, desired, control.gains);
    const Vector<T> a = vector(desired + 13) + feedback.linear, alpha = vector(desired + 16) + feedback.angular;
    store(inverse_dynamics<T>({control.inertial}, vector(control.gravity), quaternion(state + 3), vector(state + 10), a,
                              alpha),
          control.wrench);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
