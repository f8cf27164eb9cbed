// Reference integrator of free platforms: classical Runge-Kutta with cables evaluated at every stage.
// SPDX-License-Identifier: Apache-2.0
//
// The variables are position, attitude and velocity of the body frame at the centre of mass, and the angular momentum L
// about it in world axes, which is constant for a torque-free body. Rates: v, omega q / 2, force / mass + g, moment;
// omega = R I^-1 R^T L. `inertial` (4): mass, kg, and principal moments, kg m^2.
#pragma once

#include <cdpr/mechanics/anchors.hpp>
#include <cdpr/mechanics/body_frame.hpp>
#include <cdpr/scheme.hpp>

namespace cdpr::CDPR_TARGET {

namespace free_body {

template <class T> struct Point {
    Vector<T> p;
    Quaternion<T> q;
    Vector<T> v, L;
};

template <class T> CDPR_INLINE Point<T> along(Point<T> a, T c, Point<T> b) {
    return {along(a.p, c, b.p), along(a.q, c, b.q), along(a.v, c, b.v), along(a.L, c, b.L)};
}

// Return R diag(moments) R^T w.
template <class T> CDPR_INLINE Vector<T> momentum(const T* moments, Quaternion<T> q, Vector<T> w) {
    const Vector<T> own = rotate(conjugate(q), w);
    return rotate(q, Vector<T>{moments[0] * own.x, moments[1] * own.y, moments[2] * own.z});
}

// Return its inverse, R diag(moments)^-1 R^T L.
template <class T> CDPR_INLINE Vector<T> angular_velocity(const T* moments, Quaternion<T> q, Vector<T> L) {
    const Vector<T> own = rotate(conjugate(q), L);
    return rotate(q, Vector<T>{own.x / moments[0], own.y / moments[1], own.z / moments[2]});
}

}  // namespace free_body

// Body state and angular momentum of a platform state.
template <class T> struct ReferenceBegin {
    const T* offset;   // (7), body_frame.hpp
    const T* moments;  // (3), kg m^2
    T* state;          // (13), of the platform; overwritten by that of the body state
    T* body;           // (13)
    T* momentum;       // (3), kg m^2/s
    static constexpr char fields[] = "offset(7), moments(3), both state(13), body(13), momentum(3)";
};

template <class T> inline int reference_begin(ReferenceBegin<T>& start) {
    from_platform(start.offset, start.state, start.body);
    const Vector<T> omega = vector(start.body + 10);
    store(free_body::momentum(start.moments, quaternion(start.body + 3), omega), start.momentum);
    to_platform(start.offset, start.body, start.state);
    return 0;
}

// Several steps.
template <class T> struct ReferenceStep {
    const T* lines;     // (m, w), geometry.hpp, with B_i in the body frame
    const T* offset;    // (7), body_frame.hpp
    const T* inertial;  // (4)
    const T* gravity;   // (3), m/s^2
    const T* command;   // (m), N: the tensions
    const T* external;  // (6), N and N m, at the platform's origin, world axes
    T* body;            // (13)
    T* momentum;        // (3), kg m^2/s
    T* state;           // (13), of the platform, after the last step
    double step;        // s
    int64_t steps;
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), offset(7), inertial(4), gravity(3), command(m), external(6), both body(13), "
        "both momentum(3), state(13), step, steps, m, w";

    CDPR_INLINE const T* moments() const { return inertial + 1; }

    template <bool eight> CDPR_INLINE free_body::Point<T> slope(free_body::Point<T> at) const {
        const Wrench<T> pull = pull_of_cables<eight>(lines, w, m, command, at.p, at.q);
        return slope_under(pull, at, free_body::angular_velocity(moments(), at.q, at.L));
    }

    CDPR_INLINE free_body::Point<T> slope_under(Wrench<T> pull, free_body::Point<T> at, Vector<T> omega) const {
        const Wrench<T> applied = with_external(pull, offset, external, at.q);
        return {at.v, turning(at.q, omega), applied.force / inertial[0] + vector(gravity), applied.moment};
    }
};

// Advance body and momentum.
template <bool eight, class T, class Anchors> CDPR_INLINE void advance(ReferenceStep<T>& plant, Anchors& anchors) {
    const Vector<T> zero = {0.0, 0.0, 0.0};
    const free_body::Point<T> none = {zero, {0.0, 0.0, 0.0, 0.0}, zero, zero};
    for (int64_t k = 0; k < plant.steps; k++) {
        const free_body::Point<T> start = {vector(plant.body), quaternion(plant.body + 3), vector(plant.body + 7),
                                           vector(plant.momentum)};
        const free_body::Point<T> end =
            runge_kutta<T>(start, none, plant.step, [&](free_body::Point<T> at, double since) {
                anchors.place(since);
                return plant.template slope<eight>(at);
            });
        anchors.complete_step();
        store(end.p, plant.body);
        store(normalised(end.q), plant.body + 3);
        store(end.v, plant.body + 7);
        store(end.L, plant.momentum);
    }
}

template <class T, class Anchors> inline int reference_step_with(ReferenceStep<T>& plant, Anchors& anchors) {
    if (!has_anchors<T>(plant.w)) return code(T(double(BAD_INPUT)));
    if (are_eight<T>(plant.w, plant.m))
        advance<true>(plant, anchors);
    else
        advance<false>(plant, anchors);
    const Quaternion<T> q = quaternion(plant.body + 3);
    store(free_body::angular_velocity(plant.moments(), q, vector(plant.momentum)), plant.body + 10);
    to_platform(plant.offset, plant.body, plant.state);
    return 0;
}

template <class T> inline int reference_step(ReferenceStep<T>& plant) {
    RestingAnchors anchors;
    return reference_step_with(plant, anchors);
}

}  // namespace cdpr::CDPR_TARGET
