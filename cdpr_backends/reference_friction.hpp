// Reference integrator of free platforms whose cables lose tension on their exits. SPDX-License-Identifier: Apache-2.0
//
// The scheme and variables of reference.hpp, and the work of the cables. Winches hold the tensions on their side.
#pragma once

#include <cdpr_backends/reference.hpp>

namespace cdpr::CDPR_TARGET {

namespace rubbing {

// Pull of one cable or several.
template <class T> struct Pull {
    Wrench<T> wrench;  // N and N m
    T power, tension;  // W, N; of several the sum, and the largest size
};

template <class T> CDPR_INLINE Pull<T> pull(const Line<T>& cable, T command, Vector<T> v, Vector<T> omega) {
    const ExitResult<T> exit = cable.lead();
    const Vector<T> l = cable.chord(exit.point), u = l / length(l), moment = cross(cable.lever, u);
    const T rate = -dot(u, v) - dot(moment, omega);
    const T tension = cable.rubs() ? command / friction(cable, exit.wrap, rate) : command;
    return {{tension * u, tension * moment}, -tension * rate, tension};
}

// Point of the integrator: motion of the body, and work of the cables, J.
template <class T> struct Point {
    free_body::Point<T> body;
    T work;
};

template <class T> CDPR_INLINE Point<T> along(Point<T> a, T c, Point<T> b) {
    return {free_body::along(a.body, c, b.body), a.work + c * b.work};
}

}  // namespace rubbing

// Several steps.
template <class T> struct FrictionStep {
    ReferenceStep<T> plant;  // `command`: tensions at the winches
    T* cable_work;           // (1), J, since the start
    T* highest;              // (m), N, largest size of each tension at the platform since the start
    static constexpr auto fields = extended(ReferenceStep<T>::fields, "both cable_work(1), both highest(m)");

    CDPR_INLINE void observe(T tension, int64_t i) const {
        const T size = absolute(tension);
        highest[i] = select(size > highest[i], size, highest[i]);
    }
};

// Return wrench and power of the cables.
template <class T> CDPR_INLINE rubbing::Pull<T> pull_of_rubbing(const FrictionStep<T>& own,
                                                                const free_body::Point<T>& at, Vector<T> omega) {
    const ReferenceStep<T>& plant = own.plant;
    rubbing::Pull<T> sum = {{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, 0.0, 0.0};
    for (int64_t i = 0; i < plant.m; i++) {
        const Line<T> cable = line(plant.lines, plant.w, i, at.p, at.q);
        const rubbing::Pull<T> one = rubbing::pull(cable, plant.command[i], at.v, omega);
        own.observe(one.tension, i);
        sum = {sum.wrench + one.wrench, sum.power + one.power, one.tension};
    }
    return sum;
}

template <class T> CDPR_INLINE rubbing::Pull<T> pull_of_eight_rubbing(const FrictionStep<T>& own,
                                                                      const free_body::Point<T>& at, Vector<T> omega) {
    return pull_of_rubbing(own, at, omega);
}

#ifdef CDPR_LANES
template <> CDPR_INLINE rubbing::Pull<double> pull_of_eight_rubbing<double>(const FrictionStep<double>& own,
                                                                            const free_body::Point<double>& at,
                                                                            Vector<double> omega) {
    using Eight = EightRubbing;
    const ReferenceStep<double>& plant = own.plant;
    const rubbing::Pull<Lanes> each = rubbing::pull(Eight(plant.lines).at(at.p, at.q), gather(plant.command, 1),
                                                    Eight::same(at.v), Eight::same(omega));
    rubbing::Pull<double> sum = {{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, 0.0, 0.0};
    add_each(each.wrench.force, sum.wrench.force);
    add_each(each.wrench.moment, sum.wrench.moment);
    for (int i = 0; i < WIDTH; i++) {
        own.observe(each.tension.get(i), i);
        sum.power = sum.power + each.power.get(i);
    }
    return sum;
}
#endif

template <class T> inline int friction_step(FrictionStep<T>& own) {
    ReferenceStep<T>& plant = own.plant;
    if (!has_anchors<T>(plant.w)) return code(T(double(BAD_INPUT)));
    const bool eight = are_eight_rubbing<T>(plant.lines, plant.w, plant.m);
    const Vector<T> zero = {0.0, 0.0, 0.0};
    const rubbing::Point<T> none = {{zero, {0.0, 0.0, 0.0, 0.0}, zero, zero}, 0.0};
    for (int64_t k = 0; k < plant.steps; k++) {
        const rubbing::Point<T> start = {
            {vector(plant.body), quaternion(plant.body + 3), vector(plant.body + 7), vector(plant.momentum)},
            own.cable_work[0]};
        const rubbing::Point<T> end = runge_kutta<T>(start, none, plant.step, [&](rubbing::Point<T> point, double) {
            const free_body::Point<T>& at = point.body;
            const Vector<T> omega = free_body::angular_velocity(plant.moments(), at.q, at.L);
            const rubbing::Pull<T> pull =
                eight ? pull_of_eight_rubbing(own, at, omega) : pull_of_rubbing(own, at, omega);
            return rubbing::Point<T>{plant.slope_under(pull.wrench, at, omega), pull.power};
        });
        store(end.body.p, plant.body);
        store(normalised(end.body.q), plant.body + 3);
        store(end.body.v, plant.body + 7);
        store(end.body.L, plant.momentum);
        own.cable_work[0] = end.work;
    }
    const Quaternion<T> q = quaternion(plant.body + 3);
    store(free_body::angular_velocity(plant.moments(), q, vector(plant.momentum)), plant.body + 10);
    to_platform(plant.offset, plant.body, plant.state);
    return 0;
}

// Tensions at the platform of cables whose winches hold tensions.
template <class T> struct ExitTensions {
    const T* lines;    // (m, w), B_i in the body frame
    const T* body;     // (13)
    const T* command;  // (m), N, tensions at the winches
    T* tension;        // (m), N
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), body(13), command(m), tension(m), m, w";
};

template <class T> inline int exit_tensions(ExitTensions<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const Vector<T> p = vector(cables.body), v = vector(cables.body + 7), omega = vector(cables.body + 10);
    const Quaternion<T> q = quaternion(cables.body + 3);
    for (int64_t i = 0; i < cables.m; i++)
        cables.tension[i] = rubbing::pull(line(cables.lines, cables.w, i, p, q), cables.command[i], v, omega).tension;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
