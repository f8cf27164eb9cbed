// Reference integrator of platforms that turn about their held origin: classical Runge-Kutta.
// SPDX-License-Identifier: Apache-2.0
//
// The variables are the attitude and the angular momentum L about the origin, world axes. Rates: omega q / 2, moment;
// omega = R J^-1 R^T L.
#pragma once

#include <cdpr/mechanics/anchors.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/spherical.hpp>
#include <cdpr/scheme.hpp>

namespace cdpr::CDPR_TARGET {

namespace on_a_ball {

template <class T> struct Point {
    Quaternion<T> q;
    Vector<T> L;
};

template <class T> CDPR_INLINE Point<T> along(Point<T> a, T c, Point<T> b) {
    return {along(a.q, c, b.q), along(a.L, c, b.L)};
}

}  // namespace on_a_ball

// Angular momentum of a state.
template <class T> struct SphericalBegin {
    const T* packed;  // (21), spherical.hpp
    const T* state;   // (13)
    T* momentum;      // (3), kg m^2/s
    static constexpr char fields[] = "packed(21), state(13), momentum(3)";
};

template <class T> inline int spherical_begin(SphericalBegin<T>& start) {
    const Ball<T> ball = {start.packed};
    store(turned_product(ball.inertia(), quaternion(start.state + 3), vector(start.state + 10)), start.momentum);
    return 0;
}

// Several steps.
template <class T> struct SphericalStep {
    const T* lines;     // (m, w), geometry.hpp
    const T* packed;    // (21), spherical.hpp
    const T* gravity;   // (3), m/s^2
    const T* command;   // (m), N: the tensions
    const T* external;  // (6), N and N m, at the platform's origin, world axes
    T* momentum;        // (3), kg m^2/s
    T* state;           // (13): attitude and angular velocity move, position and velocity stay
    double step;        // s
    int64_t steps;
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), packed(21), gravity(3), command(m), external(6), both momentum(3), both state(13), step, "
        "steps, m, w";

    CDPR_INLINE Ball<T> ball() const { return {packed}; }

    CDPR_INLINE on_a_ball::Point<T> slope(on_a_ball::Point<T> at) const {
        const Wrench<T> applied = pull_of_cables(lines, w, m, command, vector(state), at.q) + wrench(external);
        const Vector<T> omega = turned_product(ball().inverse(), at.q, at.L);
        return {turning(at.q, omega), moment_about_ball(ball(), vector(gravity), at.q, applied.moment)};
    }
};

template <class T, class Anchors> inline int spherical_step_with(SphericalStep<T>& plant, Anchors& anchors) {
    if (!has_anchors<T>(plant.w)) return code(T(double(BAD_INPUT)));
    const on_a_ball::Point<T> none = {{0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int64_t k = 0; k < plant.steps; k++) {
        const on_a_ball::Point<T> start = {quaternion(plant.state + 3), vector(plant.momentum)};
        const on_a_ball::Point<T> end =
            runge_kutta<T>(start, none, plant.step, [&](on_a_ball::Point<T> at, double since) {
                anchors.place(since);
                return plant.slope(at);
            });
        anchors.complete_step();
        store(normalised(end.q), plant.state + 3);
        store(end.L, plant.momentum);
    }
    const Quaternion<T> q = quaternion(plant.state + 3);
    store(turned_product(plant.ball().inverse(), q, vector(plant.momentum)), plant.state + 10);
    return 0;
}

template <class T> inline int spherical_step(SphericalStep<T>& plant) {
    RestingAnchors anchors;
    return spherical_step_with(plant, anchors);
}

}  // namespace cdpr::CDPR_TARGET
