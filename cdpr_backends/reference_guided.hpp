// Reference integrator of platforms on a guide: classical Runge-Kutta in the guide's coordinates.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/anchors.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/guide.hpp>
#include <cdpr/scheme.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> CDPR_INLINE GuidedMotion<T> along(GuidedMotion<T> a, T c, GuidedMotion<T> b) {
    return {along(a.position, c, b.position), a.angle + c * b.angle, along(a.velocity, c, b.velocity),
            a.spin + c * b.spin};
}

// Several steps.
template <class T> struct GuidedStep {
    const T* guide;     // (6), guide.hpp
    const T* lines;     // (m, w), geometry.hpp
    const T* inertial;  // (13), guide.hpp
    const T* gravity;   // (3), m/s^2
    const T* command;   // (m), N: the tensions
    const T* external;  // (6), N and N m, at the platform's origin, world axes
    T* motion;          // (8): position, m; angle, rad; velocity, m/s; rate of the angle, rad/s
    T* state;           // (13), of the platform, after the last step
    double step;        // s
    int64_t steps;
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "guide(6), lines(m, w >= 6), inertial(13), gravity(3), command(m), external(6), both motion(8), state(13), "
        "step, steps, m, w";

    CDPR_INLINE GuidedMotion<T> slope(GuidedMotion<T> at) const {
        const Quaternion<T> q = hinge_attitude(guide, at.angle);
        const Wrench<T> applied = pull_of_cables(lines, w, m, command, at.position, q) + wrench(external);
        const GuidedAcceleration<T> a =
            guided_acceleration(guide, inertial, vector(gravity), at.angle, at.spin, applied);
        return {at.velocity, at.spin, a.linear, a.angular};
    }
};

template <class T, class Anchors> inline int guided_step_with(GuidedStep<T>& plant, Anchors& anchors) {
    if (!has_anchors<T>(plant.w)) return code(T(double(BAD_INPUT)));
    const GuidedMotion<T> none = {{0.0, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}, 0.0};
    for (int64_t k = 0; k < plant.steps; k++) {
        const auto slope = [&](GuidedMotion<T> at, double since) {
            anchors.place(since);
            return plant.slope(at);
        };
        store(runge_kutta<T>(guided_motion(plant.motion), none, plant.step, slope), plant.motion);
        anchors.complete_step();
    }
    write_state(plant.guide, guided_motion(plant.motion), plant.state);
    return 0;
}

template <class T> inline int guided_step(GuidedStep<T>& plant) {
    RestingAnchors anchors;
    return guided_step_with(plant, anchors);
}

}  // namespace cdpr::CDPR_TARGET
