// Proportional, integral and damping control in task space: cdpr_controllers/pid.py. SPDX-License-Identifier:
// Apache-2.0
#pragma once

#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/proportional_derivative.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct PidControl {
    const T* gains;     // (12): kp (6), 1/s^2, and kd (6), 1/s, of x, y, z, rx, ry, rz
    const T* per_step;  // (2, 6): ki times the control step, 1/s^2, and limits of the integral, m/s^2 and rad/s^2
    const T* inertial;  // (13), `Robot.inertial`
    const T* gravity;   // (3), m/s^2, world
    const T* report;    // (4), of the previous distribution; the status is the first
    const T* state;     // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    const T* desired;   // (19): the same, and accelerations
    T* integral;        // (6), m/s^2 and rad/s^2, of ki times the error
    T* wrench;          // (6), N and N m, about the platform's origin
    static constexpr char fields[] =
        "gains(12), per_step(2, 6), inertial(13), gravity(3), report(4), state(13), desired(19), both integral(6), "
        "wrench(6)";
};

// Advance the integral z by one control step, within its limits. If the cables did not exert the previous wrench, it
// only moves towards zero.
template <class T> CDPR_INLINE void integrate(const PidControl<T>& control, int i, T error) {
    const Truth<T> delivered = control.report[0] == T(double(OK));
    const T limit = control.per_step[6 + i], z = control.integral[i], change = control.per_step[i] * error;
    const T within = smaller(larger(z + change, -limit), limit);
    control.integral[i] = select(delivered | (z * change < T(0.0)), within, z);
}

template <class T> inline int pid(PidControl<T>& control) {
    const T *state = control.state, *desired = control.desired, *z = control.integral;
    const Vector<T> turn = attitude_error(state, desired);
    const Feedback<T> feedback = proportional_derivative(state, desired, control.gains, turn);
    for (int i = 0; i < 3; i++) integrate(control, i, desired[i] - state[i]);
    integrate(control, 3, turn.x);
    integrate(control, 4, turn.y);
    integrate(control, 5, turn.z);
    const Vector<T> a = feedback.linear + vector(z), alpha = feedback.angular + vector(z + 3);
    store(inverse_dynamics<T>({control.inertial}, vector(control.gravity), quaternion(state + 3), no_vector<T>(), a,
                              alpha),
          control.wrench);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
