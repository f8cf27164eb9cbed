// Platforms on a guide that blocks some directions. SPDX-License-Identifier: Apache-2.0
//
// See `cdpr.mechanics.guide`. `guide` (6): 1 along and about each free world axis, so that the last three are the
// hinge's axis, if there is one; else all three are 0. `inertial` (13): mass, kg, centre of mass (3), m, inertia about
// it (3, 3), kg m^2, platform axes.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/status.hpp>
#include <cdpr/wrench.hpp>

namespace cdpr::CDPR_TARGET {

// Of the platform's origin, m/s^2, and about the hinge, rad/s^2; world axes.
template <class T> struct GuidedAcceleration {
    Vector<T> linear;
    T angular;
};

// Coordinates of a guide and their rates.
template <class T> struct GuidedMotion {
    Vector<T> position;  // m, world
    T angle;             // rad, about the hinge
    Vector<T> velocity;  // m/s
    T spin;              // rad/s
};

template <class T> CDPR_INLINE GuidedMotion<T> guided_motion(const T* array) {
    return {vector(array), array[3], vector(array + 4), array[7]};
}

template <class T> CDPR_INLINE void store(GuidedMotion<T> motion, T* array) {
    store(motion.position, array);
    array[3] = motion.angle;
    store(motion.velocity, array + 4);
    array[7] = motion.spin;
}

template <class T> CDPR_INLINE Quaternion<T> hinge_attitude(const T* guide, T angle) {
    const T half = 0.5 * angle, s = sine(half);
    return {cosine(half), s * guide[3], s * guide[4], s * guide[5]};
}

template <class T> CDPR_INLINE Vector<T> along_axes(const T* guide, Vector<T> v) {
    return {guide[0] * v.x, guide[1] * v.y, guide[2] * v.z};
}

// Return the acceleration under a wrench about the origin, world axes, and gravity, m/s^2. With a the hinge's axis, r
// from origin to centre of mass, c = a x r along the free axes and f = force + m g - m a x (a x r) spin^2 along them: m
// v' + m c w' = f and c . m v' + J w' = a . (moment + r x m g), J the inertia about the hinge, which a rotation about
// it does not change.
template <class T> CDPR_INLINE GuidedAcceleration<T> guided_acceleration(const T* guide, const T* inertial,
                                                                         Vector<T> gravity, T angle, T spin,
                                                                         Wrench<T> applied) {
    const T mass = inertial[0];
    const Vector<T> axis = vector(guide + 3), r = rotate(hinge_attitude(guide, angle), vector(inertial + 1));
    const Vector<T> c = cross(axis, r), weight = mass * gravity;
    const Vector<T> f = along_axes(guide, applied.force + weight - mass * spin * spin * cross(axis, c));
    const Vector<T> free = along_axes(guide, c);
    T alpha = 0.0;
    const Truth<T> turns = dot(axis, axis) > T(0.0);
    if (any(turns)) {
        const T inertia = dot(axis, product(inertial + 4, axis)) + mass * dot(c, c);
        const T torque = dot(axis, applied.moment) + dot(axis, cross(r, weight));
        alpha = select(turns, (torque - dot(free, f)) / (inertia - mass * dot(free, free)), alpha);
    }
    return {f / mass - alpha * free, alpha};
}

// Write the state (13) of a platform with these coordinates.
template <class T> CDPR_INLINE void write_state(const T* guide, GuidedMotion<T> motion, T* state) {
    store(motion.position, state);
    store(hinge_attitude(guide, motion.angle), state + 3);
    store(motion.velocity, state + 7);
    store(motion.spin * vector(guide + 3), state + 10);
}

// Body state of an engine's joint coordinates.
template <class T> struct GuideState {
    const T* guide;       // (6)
    const int64_t* rows;  // (n), rows of a twist of the coordinates; the same in all lanes
    const T* home;        // (3), m, world, zero of the slides
    const T* coordinate;  // (n), m; rad from the upright platform
    const T* rate;        // (n), m/s and rad/s
    T* body;              // (13)
    int64_t n;
    static constexpr char fields[] = "guide(6), rows(n), home(3), coordinate(n), rate(n), body(13), n";
};

template <class T> inline int guide_state(GuideState<T>& joints) {
    T p[3] = {joints.home[0], joints.home[1], joints.home[2]}, v[3] = {0.0, 0.0, 0.0}, angle = 0.0, spin = 0.0;
    for (int64_t k = 0; k < joints.n; k++) {
        const int64_t row = joints.rows[k];
        if (row >= 0 && row < 3) {
            p[row] += joints.coordinate[k];
            v[row] = joints.rate[k];
        } else {
            angle = joints.coordinate[k];
            spin = joints.rate[k];
        }
    }
    write_state<T>(joints.guide, {vector(p), angle, vector(v), spin}, joints.body);
    return 0;
}

// Forces along an engine's joint coordinates.
template <class T> struct GuideForces {
    const int64_t* rows;  // (n), as of GuideState
    const T* applied;     // (6), N and N m, about the platform's origin, world axes
    T* forces;            // (n), N and N m
    int64_t n;
    static constexpr char fields[] = "rows(n), applied(6), forces(n), n";
};

template <class T> inline int guide_forces(GuideForces<T>& joints) {
    for (int64_t k = 0; k < joints.n; k++) {
        const int64_t row = joints.rows[k];
        if (row < 0 || row >= 6) return code(T(double(BAD_INPUT)));
        joints.forces[k] = joints.applied[row];
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
