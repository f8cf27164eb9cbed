// Wrench for a desired motion of the platform. SPDX-License-Identifier: Apache-2.0
//
// Newton and Euler about the centre of mass G, which lies at r = R c from the platform's origin (Siciliano, Sciavicco,
// Villani, Oriolo, Robotics (2009), section 7.5).
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/wrench.hpp>

namespace cdpr::CDPR_TARGET {

// `Robot.inertial`: mass, kg; centre of mass c, m, and inertia about it, kg m^2, row by row, platform axes.
template <class T> struct Inertial {
    static constexpr int MASS = 0, CENTER = 1, INERTIA = 4, COUNT = 13;

    const T* numbers;

    CDPR_INLINE T mass() const { return numbers[MASS]; }
    CDPR_INLINE Vector<T> lever(Quaternion<T> q) const { return rotate(q, vector(numbers + CENTER)); }  // r

    // I v, v along platform axes.
    CDPR_INLINE Vector<T> times(Vector<T> v) const { return product(numbers + INERTIA, v); }

    // R I R^T v, v along world axes.
    CDPR_INLINE Vector<T> turned_times(Quaternion<T> q, Vector<T> v) const {
        return rotate(q, times(rotate(conjugate(q), v)));
    }
};

// Return the wrench about the platform's origin for the acceleration of G, m/s^2, and the rate of the angular momentum
// about G, N m, with r = R c; world axes.
template <class T> CDPR_INLINE Wrench<T> inverse_dynamics(T mass, Vector<T> gravity, Vector<T> r,
                                                          Vector<T> acceleration, Vector<T> momentum_rate) {
    const Vector<T> force = mass * (acceleration - gravity);
    return {force, momentum_rate + cross(r, force)};
}

// Return the wrench about the platform's origin for the acceleration a, m/s^2, of its origin and alpha, rad/s^2, at
// attitude q and angular velocity omega, rad/s; world axes: force = m (a + alpha x r + omega x (omega x r) - g), moment
// = I alpha + omega x I omega + r x force.
template <class T> CDPR_INLINE Wrench<T> inverse_dynamics(Inertial<T> body, Vector<T> gravity, Quaternion<T> q,
                                                          Vector<T> omega, Vector<T> a, Vector<T> alpha) {
    const Vector<T> r = body.lever(q);
    const Vector<T> tangential = cross(alpha, r), centripetal = cross(omega, cross(omega, r));
    const Vector<T> euler = body.turned_times(q, alpha), gyroscopic = cross(omega, body.turned_times(q, omega));
    return inverse_dynamics(body.mass(), gravity, r, a + tangential + centripetal, euler + gyroscopic);
}

template <class T> CDPR_INLINE Vector<T> no_vector() { return {0.0, 0.0, 0.0}; }

template <class T> struct InverseDynamics {
    const T* inertial;              // (13), as of Inertial
    const T* gravity;               // (3), m/s^2, world
    const T* state;                 // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    const T* acceleration;          // (3), of the platform's origin, m/s^2
    const T* angular_acceleration;  // (3), rad/s^2
    T* wrench;                      // (6), N and N m, about the platform's origin
    static constexpr char fields[] =
        "inertial(13), gravity(3), state(13), acceleration(3), angular_acceleration(3), wrench(6)";
};

template <class T> inline int inverse_dynamics(InverseDynamics<T>& wanted) {
    const Wrench<T> wrench = inverse_dynamics<T>({wanted.inertial}, vector(wanted.gravity),
                                                 quaternion(wanted.state + 3), vector(wanted.state + 10),
                                                 vector(wanted.acceleration), vector(wanted.angular_acceleration));
    store(wrench, wanted.wrench);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
