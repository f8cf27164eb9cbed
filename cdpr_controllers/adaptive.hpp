// Adaptive control in task space: cdpr_controllers/adaptive.py. SPDX-License-Identifier: Apache-2.0
//
// Slotine and Li, "On the adaptive control of robot manipulators", International Journal of Robotics Research 6(3)
// (1987), for a rigid body about its origin. With mass m, first moment h (m times the centre of mass, world axes) and
// inertia I about the origin, and the reference velocity v_r, omega_r,
//
//     force  = m (a_r - g) + alpha_r x h + omega_r x (omega x h),
//     moment = h x (a_r - g) + I alpha_r + (omega x I omega_r - I (omega x omega_r) + omega_r x I omega) / 2.
//
// The terms with omega and omega_r are C(omega) times the reference velocity, with C such that M' - 2 C is skew.
#pragma once

#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/proportional_derivative.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct AdaptiveControl {
    const T* gains;     // (2): slope, 1/s; kd, 1/s
    const T* rates;     // (2), times the control step: mass_gain, s^3/m^2, and center_gain, s^3
    const T* range;     // (3): lowest and highest multiple of the nominal mass; largest coordinate of the centre, m
    const T* inertial;  // (13), `Robot.inertial`: nominal
    const T* gravity;   // (3), m/s^2, world
    const T* report;    // (4), of the previous distribution; the status is the first
    const T* state;     // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    const T* desired;   // (19): the same, and accelerations
    T* deviation;  // (4): estimates minus nominal values of the mass, kg, and the first moment, kg m, platform axes
    T* mass;       // (1), kg, the estimate of this step
    T* center;     // (3), m, platform axes
    T* wrench;     // (6), N and N m, about the platform's origin
    static constexpr char fields[] =
        "gains(2), rates(2), range(3), inertial(13), gravity(3), report(4), state(13), desired(19), "
        "both deviation(4), mass(1), center(3), wrench(6)";

    CDPR_INLINE Inertial<T> nominal() const { return {inertial}; }
    CDPR_INLINE Vector<T> nominal_moment() const {
        return nominal().mass() * vector(inertial + Inertial<T>::CENTER);  // kg m, platform axes
    }
};

template <class T> CDPR_INLINE T clamped(T value, T low, T high) { return smaller(larger(value, low), high); }

// Nominal inertia about the platform's origin times a vector, world axes: that about the centre of mass, and the term
// of Huygens and Steiner.
template <class T> CDPR_INLINE Vector<T> about_origin(Inertial<T> body, Quaternion<T> q, Vector<T> v) {
    const Vector<T> r = body.lever(q);
    return body.turned_times(q, v) + body.mass() * cross(r, cross(v, r));
}

// Write the estimates for the next step within their range. They do not change if the cables did not exert the previous
// wrench. `slope` (4) is the derivative of s . wrench by mass and first moment.
template <class T> CDPR_INLINE void adapt(const AdaptiveControl<T>& control, T by_mass, Vector<T> by_moment) {
    const Truth<T> delivered = control.report[0] == T(double(OK));
    const T m0 = control.nominal().mass();
    const T gain = select(delivered, m0 * control.rates[0], T(0.0));
    const T turning = select(delivered, m0 * control.rates[1], T(0.0));
    const T mass = clamped(m0 + control.deviation[0] + gain * by_mass, m0 * control.range[0], m0 * control.range[1]);
    const T most = mass * control.range[2];
    const Vector<T> h0 = control.nominal_moment();
    const Vector<T> h = h0 + vector(control.deviation + 1) + turning * by_moment;
    const Vector<T> within = {clamped(h.x, -most, most), clamped(h.y, -most, most), clamped(h.z, -most, most)};
    control.deviation[0] = mass - m0;
    store(within - h0, control.deviation + 1);
}

template <class T> inline int adaptive(AdaptiveControl<T>& control) {
    const T *state = control.state, *desired = control.desired;
    const T slope = control.gains[0], kd = control.gains[1];
    const Quaternion<T> q = quaternion(state + 3);
    const Vector<T> omega = vector(state + 10), slip = vector(desired + 7) - vector(state + 7);
    const Vector<T> spin = vector(desired + 10) - omega;
    const Vector<T> s = slip + slope * (vector(desired) - vector(state));
    const Vector<T> sigma = spin + slope * attitude_error(state, desired);
    const Vector<T> a = vector(desired + 13) + slope * slip - vector(control.gravity);
    const Vector<T> alpha = vector(desired + 16) + slope * spin, reference = omega + sigma;

    const Inertial<T> body = control.nominal();
    const T mass = body.mass() + control.deviation[0];
    const Vector<T> moment = control.nominal_moment() + vector(control.deviation + 1), h = rotate(q, moment);
    *control.mass = mass;
    store((1.0 / mass) * moment, control.center);

    const Vector<T> about = about_origin(body, q, omega);
    const Vector<T> coriolis = cross(omega, about_origin(body, q, reference)) -
                               about_origin(body, q, cross(omega, reference)) + cross(reference, about);
    const Vector<T> force = mass * a + cross(alpha, h) + cross(reference, cross(omega, h)) + (kd * body.mass()) * s;
    const Vector<T> torque = cross(h, a) + about_origin(body, q, alpha + kd * sigma) + T(0.5) * coriolis;
    store(Wrench<T>{force, torque}, control.wrench);
    const Vector<T> by_h = cross(s, alpha) + cross(cross(s, reference), omega) + cross(a, sigma);
    adapt(control, dot(a, s), rotate(conjugate(q), by_h));
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
