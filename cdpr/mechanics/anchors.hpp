// Anchors on the frame that move, as live arrays. SPDX-License-Identifier: Apache-2.0
//
// An operation of the caller writes position, velocity and acceleration of all anchors at a time. Plants call it at the
// time of each evaluation of their cables, the loop at that of its sample. Exits are points. A kernel takes the anchors
// as an argument: `RestingAnchors` add nothing to it.
#pragma once

#include <cdpr/call_at.hpp>
#include <cdpr/field.hpp>
#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

// Return a row of `anchors` (3, m, 3): positions, m, velocities, m/s, and accelerations, m/s^2, world.
CDPR_INLINE Vector<double> anchor_derivative(const double* anchors, int order, int64_t m, int64_t i) {
    return vector(anchors + 3 * (order * m + i));
}

// Positions at a time in the table of lines of one owner.
struct PlaceAnchors {
    const int64_t* mover;   // (2): operation that writes `anchors` at a time, and its place
    const double* anchors;  // (3, m, 3)
    const double* apart;    // (m, 3), m, from these anchors to those of the owner
    double* lines;          // (m, w), geometry.hpp; their A_i are written
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "mover(2), anchors(3, m, 3), apart(m, 3), both lines(m, w >= 6), m, w";
};

// Return the code of the operation that moves the anchors. If that is not 0, the positions are NaN, and so is the
// motion of a plant.
inline int place_anchors(PlaceAnchors& owner, double time) {
    const int code = call_at(owner.mover[0], owner.mover[1], time);
    const Vector<double> none = {NOT_A_NUMBER, NOT_A_NUMBER, NOT_A_NUMBER};
    for (int64_t i = 0; i < owner.m; i++) {
        const Vector<double> place = anchor_derivative(owner.anchors, 0, owner.m, i) + vector(owner.apart + 3 * i);
        store(code == 0 ? place : none, owner.lines + i * owner.w);
    }
    return code;
}

// Anchors at rest.
struct RestingAnchors {
    static constexpr bool moving = false;

    CDPR_INLINE void place(double) {}
    CDPR_INLINE void complete_step() {}
};

// Last fields of the kernels of plants with anchors that move.
struct AnchorMotion {
    const int64_t* placing;  // (2): operation that writes `anchors` and the A_i of `lines` at a time, and its place
    const double* anchors;   // (3, m, 3)
    double* past;            // (m + 1): u . A' of each cable at the last evaluation, m/s, and its time, s
    int64_t* taken;          // (1), physics steps since the reset
    double every;            // s, physics step
    static constexpr char fields[] = "placing(2), anchors(3, m, 3), both past(m + 1), both taken(1), every";
};

// Anchors that move, during a call of a kernel.
struct MovingAnchors {
    static constexpr bool moving = true;

    AnchorMotion& own;
    int64_t m;
    double now = 0.0;  // s

    CDPR_INLINE Vector<double> velocity(int64_t i) const { return anchor_derivative(own.anchors, 1, m, i); }
    CDPR_INLINE Vector<double> acceleration(int64_t i) const { return anchor_derivative(own.anchors, 2, m, i); }

    // Place the anchors at a time, s, after the start of the present step.
    CDPR_INLINE void place(double since) {
        now = double(*own.taken) * own.every + since;
        call_at(own.placing[0], own.placing[1], now);
    }
    CDPR_INLINE void complete_step() { ++*own.taken; }
};

// A kernel's problem for a plant with anchors that move.
template <class Step> struct Anchored {
    Step plant;
    AnchorMotion anchors;
    static constexpr auto fields = extended(Step::fields, AnchorMotion::fields);
};

// Positions at the start of the next step of a plant with one evaluation per step, which is then counted.
struct PlaceForStep {
    const int64_t* placing;  // (2), as in AnchorMotion
    int64_t* taken;          // (1)
    double every;            // s
    static constexpr char fields[] = "placing(2), both taken(1), every";
};

inline int place_for_step(PlaceForStep& plant) {
    const double time = double(*plant.taken) * plant.every;
    ++*plant.taken;
    call_at(plant.placing[0], plant.placing[1], time);
    return 0;
}

// Effect of the motion of the anchors on an observed sample: on the rates, and on the work of tensions that were held
// since the sample before (by the trapezoidal rule).
struct ObservedAnchors {
    const double* anchors;  // (3, m, 3)
    const double* matrix;   // (6, m), wrench matrix
    const double* tension;  // (m), N
    double* past;           // (m), m/s: u . A' of the sample before, then of this one
    double* rate;           // (m), m/s
    double* work;           // (1), J
    double period;          // s, since the sample before
    int64_t m;
    static constexpr char fields[] =
        "anchors(3, m, 3), matrix(6, m), tension(m), both past(m), both rate(m), both work(1), period, m";
};

inline int observe_anchors(ObservedAnchors& cables) {
    const int64_t m = cables.m;
    double work = 0.0;
    for (int64_t i = 0; i < m; i++) {
        const Vector<double> u = {cables.matrix[i], cables.matrix[m + i], cables.matrix[2 * m + i]};
        const double along = dot(u, anchor_derivative(cables.anchors, 1, m, i));
        work += cables.tension[i] * (0.5 * cables.period * (cables.past[i] + along));
        cables.past[i] = along;
        cables.rate[i] += along;
    }
    *cables.work += work;
    return 0;
}

// A kernel as a function of its problem with anchors that move.
template <class Step, int (*kernel)(Step&, MovingAnchors&), int64_t (*count)(const Step&)>
inline int anchored(Anchored<Step>& problem) {
    MovingAnchors anchors = {problem.anchors, count(problem.plant)};
    return kernel(problem.plant, anchors);
}

template <class Step> inline int64_t count(const Step& step) { return step.m; }
template <class Step> inline int64_t count_of_plant(const Step& step) { return step.plant.m; }

}  // namespace cdpr::CDPR_TARGET
