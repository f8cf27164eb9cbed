// Reference integrator of free platforms whose cables lose tension on their exits. SPDX-License-Identifier: Apache-2.0
//
// The scheme and variables of reference.hpp, and the work of the cables. Winches hold the tensions on their side.
#pragma once

#include <cdpr/same_bits.hpp>
#include <cdpr_backends/reference.hpp>

namespace cdpr::CDPR_TARGET {

namespace rubbing {

// Pull of one cable or several.
template <class T> struct Pull {
    Wrench<T> wrench;  // N and N m
    T power, tension;  // W, N; of several cables the power only
};

template <class T> CDPR_INLINE Pull<T> no_pull() { return {{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, 0.0, 0.0}; }

template <class T> CDPR_INLINE Pull<T> pull(const Line<T>& cable, T command, Vector<T> v, Vector<T> omega) {
    const ExitResult<T> exit = cable.lead();
    const Vector<T> l = cable.chord(exit.point), u = l / length(l), moment = cross(cable.lever, u);
    const T rate = -dot(u, v) - dot(moment, omega);
    const T tension = cable.rubs() ? command / friction(cable, exit.sine, exit.cosine, rate) : command;
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

// Pull of the cables at the last state at which the tensions were read: the first stage of a step from there.
template <class T> struct LastPull {
    static constexpr int BODY = 7, COMMAND = 20;

    T* numbers;  // (2*m + 20): force, moment and power; body (13); commands (m); tensions (m)
    int64_t m;

    CDPR_INLINE T* tension() const { return numbers + COMMAND + m; }
    CDPR_INLINE bool is_of(const T* body, const T* command) const {
        return same_bits(numbers + BODY, body, 13) && same_bits(numbers + COMMAND, command, m);
    }
    CDPR_INLINE rubbing::Pull<T> pull() const { return {wrench(numbers), numbers[6], 0.0}; }

    CDPR_INLINE void keep(rubbing::Pull<T> pull, const T* body, const T* command, const T* tensions) const {
        store(pull.wrench, numbers);
        numbers[6] = pull.power;
        for (int64_t i = 0; i < 13; i++) numbers[BODY + i] = body[i];
        for (int64_t i = 0; i < m; i++) numbers[COMMAND + i] = command[i];
        for (int64_t i = 0; i < m; i++) tension()[i] = tensions[i];
    }
};

// Several steps.
template <class T> struct FrictionStep {
    ReferenceStep<T> plant;  // `command`: tensions at the winches
    T* cable_work;           // (1), J, since the start
    T* highest;              // (m), N, largest size of each tension at the platform since the start
    T* last;                 // (2*m + 20), LastPull; NaN after a change of `lines`
    T* pulled;               // (m), work space: tensions at the platform, N
    static constexpr auto fields =
        extended(ReferenceStep<T>::fields, "both cable_work(1), both highest(m), both last(2*m + 20), work pulled(m)");

    CDPR_INLINE void observe(const T* tension) const {
        for (int64_t i = 0; i < plant.m; i++) {
            const T size = absolute(tension[i]);
            highest[i] = select(size > highest[i], size, highest[i]);
        }
    }
};

namespace rubbing {

// Cables one after the other.
template <class T> struct Each {
    const T* lines;
    const T* command;
    int64_t m, w;

    // Return the pull of all cables; write the tension of each at the platform.
    CDPR_INLINE Pull<T> pull(Vector<T> p, Quaternion<T> q, Vector<T> v, Vector<T> omega, T* tension) const {
        Pull<T> sum = no_pull<T>();
        for (int64_t i = 0; i < m; i++) {
            const Pull<T> one = rubbing::pull(line(lines, w, i, p, q), command[i], v, omega);
            tension[i] = one.tension;
            sum = {sum.wrench + one.wrench, sum.power + one.power, 0.0};
        }
        return sum;
    }
};

#ifdef CDPR_LANES
// Eight cables side by side.
struct Eight {
    EightRubbing lines;
    Lanes command;

    CDPR_INLINE Pull<double> pull(Vector<double> p, Quaternion<double> q, Vector<double> v, Vector<double> omega,
                                  double* tension) const {
        const Pull<Lanes> each =
            rubbing::pull(lines.at(p, q), command, EightRubbing::same(v), EightRubbing::same(omega));
        scatter(each.tension, tension);
        Pull<double> sum = no_pull<double>();
        add_each(each.wrench.force, sum.wrench.force);
        add_each(each.wrench.moment, sum.wrench.moment);
        for (int i = 0; i < WIDTH; i++) sum.power = sum.power + each.power.get(i);
        return sum;
    }
};
#endif

// Call `use` with the cables in the form that is quickest.
template <class T, class Use>
CDPR_INLINE void with_cables(const T* lines, const T* command, int64_t m, int64_t w, Use use) {
    use(Each<T>{lines, command, m, w});
}

#ifdef CDPR_LANES
template <class Use>
CDPR_INLINE void with_cables(const double* lines, const double* command, int64_t m, int64_t w, Use use) {
    if (are_eight_rubbing<double>(lines, w, m))
        use(Eight{EightRubbing(lines), gather(command, 1)});
    else
        use(Each<double>{lines, command, m, w});
}
#endif

template <class T, class Cables> CDPR_INLINE void advance(FrictionStep<T>& own, const Cables& cables) {
    ReferenceStep<T>& plant = own.plant;
    const LastPull<T> last = {own.last, plant.m};
    const Vector<T> zero = {0.0, 0.0, 0.0};
    const Point<T> none = {{zero, {0.0, 0.0, 0.0, 0.0}, zero, zero}, 0.0};
    for (int64_t k = 0; k < plant.steps; k++) {
        const Point<T> start = {
            {vector(plant.body), quaternion(plant.body + 3), vector(plant.body + 7), vector(plant.momentum)},
            own.cable_work[0]};
        bool known = k == 0 && last.is_of(plant.body, plant.command);
        const Point<T> end = runge_kutta<T>(start, none, plant.step, [&](const Point<T>& point, double) {
            const free_body::Point<T>& at = point.body;
            const Vector<T> omega = free_body::angular_velocity(plant.moments(), at.q, at.L);
            const Pull<T> pull = known ? last.pull() : cables.pull(at.p, at.q, at.v, omega, own.pulled);
            own.observe(known ? last.tension() : own.pulled);
            known = false;
            return Point<T>{plant.slope_under(pull.wrench, at, omega), pull.power};
        });
        store(end.body.p, plant.body);
        store(normalised(end.body.q), plant.body + 3);
        store(end.body.v, plant.body + 7);
        store(end.body.L, plant.momentum);
        own.cable_work[0] = end.work;
    }
}

}  // namespace rubbing

template <class T> inline int friction_step(FrictionStep<T>& own) {
    ReferenceStep<T>& plant = own.plant;
    if (!has_anchors<T>(plant.w)) return code(T(double(BAD_INPUT)));
    rubbing::with_cables(plant.lines, plant.command, plant.m, plant.w,
                         [&](const auto& cables) { rubbing::advance(own, cables); });
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
    T* last;           // (2*m + 20), LastPull
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), body(13), command(m), tension(m), last(2*m + 20), m, w";
};

template <class T> inline int exit_tensions(ExitTensions<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const T* const body = cables.body;
    rubbing::with_cables(cables.lines, cables.command, cables.m, cables.w, [&](const auto& each) {
        const rubbing::Pull<T> pull =
            each.pull(vector(body), quaternion(body + 3), vector(body + 7), vector(body + 10), cables.tension);
        LastPull<T>{cables.last, cables.m}.keep(pull, body, cables.command, cables.tension);
    });
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
