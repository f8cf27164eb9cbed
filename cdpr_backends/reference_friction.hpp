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
    T power, tension;  // W, N; of several cables the power only
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

namespace rubbing {

// Cables one after the other.
template <class T> struct Each {
    CDPR_INLINE Pull<T> pull(const FrictionStep<T>& own, const free_body::Point<T>& at, Vector<T> omega) const {
        const ReferenceStep<T>& plant = own.plant;
        Pull<T> sum = {{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, 0.0, 0.0};
        for (int64_t i = 0; i < plant.m; i++) {
            const Line<T> cable = line(plant.lines, plant.w, i, at.p, at.q);
            const Pull<T> one = rubbing::pull(cable, plant.command[i], at.v, omega);
            own.observe(one.tension, i);
            sum = {sum.wrench + one.wrench, sum.power + one.power, 0.0};
        }
        return sum;
    }
};

template <class T, class Cables> CDPR_INLINE void advance(FrictionStep<T>& own, const Cables& cables) {
    ReferenceStep<T>& plant = own.plant;
    const Vector<T> zero = {0.0, 0.0, 0.0};
    const Point<T> none = {{zero, {0.0, 0.0, 0.0, 0.0}, zero, zero}, 0.0};
    for (int64_t k = 0; k < plant.steps; k++) {
        const Point<T> start = {
            {vector(plant.body), quaternion(plant.body + 3), vector(plant.body + 7), vector(plant.momentum)},
            own.cable_work[0]};
        const Point<T> end = runge_kutta<T>(start, none, plant.step, [&](const Point<T>& point, double) {
            const free_body::Point<T>& at = point.body;
            const Vector<T> omega = free_body::angular_velocity(plant.moments(), at.q, at.L);
            const Pull<T> pull = cables.pull(own, at, omega);
            return Point<T>{plant.slope_under(pull.wrench, at, omega), pull.power};
        });
        store(end.body.p, plant.body);
        store(normalised(end.body.q), plant.body + 3);
        store(end.body.v, plant.body + 7);
        store(end.body.L, plant.momentum);
        own.cable_work[0] = end.work;
    }
}

// Advance eight cables side by side; return whether there are eight.
template <class T> CDPR_INLINE bool advance_eight(FrictionStep<T>&) { return false; }

#ifdef CDPR_LANES
struct Eight {
    EightRubbing lines;
    Lanes command;

    CDPR_INLINE Pull<double> pull(const FrictionStep<double>& own, const free_body::Point<double>& at,
                                  Vector<double> omega) const {
        const Vector<Lanes> v = EightRubbing::same(at.v), turning = EightRubbing::same(omega);
        const Pull<Lanes> each = rubbing::pull(lines.at(at.p, at.q), command, v, turning);
        Pull<double> sum = {{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, 0.0, 0.0};
        add_each(each.wrench.force, sum.wrench.force);
        add_each(each.wrench.moment, sum.wrench.moment);
        for (int i = 0; i < WIDTH; i++) {
            own.observe(each.tension.get(i), i);
            sum.power = sum.power + each.power.get(i);
        }
        return sum;
    }
};

template <> CDPR_INLINE bool advance_eight<double>(FrictionStep<double>& own) {
    const ReferenceStep<double>& plant = own.plant;
    if (!are_eight_rubbing<double>(plant.lines, plant.w, plant.m)) return false;
    const Eight cables = {EightRubbing(plant.lines), gather(plant.command, 1)};
    advance(own, cables);
    return true;
}
#endif

}  // namespace rubbing

template <class T> inline int friction_step(FrictionStep<T>& own) {
    ReferenceStep<T>& plant = own.plant;
    if (!has_anchors<T>(plant.w)) return code(T(double(BAD_INPUT)));
    if (!rubbing::advance_eight(own)) rubbing::advance(own, rubbing::Each<T>());
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

namespace rubbing {

// Write the tensions of eight cables; return whether there are eight.
template <class T> CDPR_INLINE bool write_eight(ExitTensions<T>&) { return false; }

#ifdef CDPR_LANES
template <> CDPR_INLINE bool write_eight<double>(ExitTensions<double>& cables) {
    if (!are_eight_rubbing<double>(cables.lines, cables.w, cables.m)) return false;
    const Vector<Lanes> v = EightRubbing::same(vector(cables.body + 7));
    const Vector<Lanes> omega = EightRubbing::same(vector(cables.body + 10));
    const Line<Lanes> eight = EightRubbing(cables.lines).at(vector(cables.body), quaternion(cables.body + 3));
    scatter(pull(eight, gather(cables.command, 1), v, omega).tension, cables.tension);
    return true;
}
#endif

}  // namespace rubbing

template <class T> inline int exit_tensions(ExitTensions<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    if (rubbing::write_eight(cables)) return 0;
    const Vector<T> p = vector(cables.body), v = vector(cables.body + 7), omega = vector(cables.body + 10);
    const Quaternion<T> q = quaternion(cables.body + 3);
    for (int64_t i = 0; i < cables.m; i++)
        cables.tension[i] = rubbing::pull(line(cables.lines, cables.w, i, p, q), cables.command[i], v, omega).tension;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
