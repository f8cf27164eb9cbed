// Reference integrator of cables on winches. SPDX-License-Identifier: Apache-2.0
//
// Classical Runge-Kutta of order four in body, work of the cables, and winches, for free and guided platforms.
#pragma once

#include <cdpr/mechanics/body_frame.hpp>
#include <cdpr/mechanics/winches.hpp>
#include <cdpr/scheme.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct WinchRungeKutta {
    Plant<T> plant;
    T* state;     // (13), of the platform
    T* points;    // (4, 14 + s), work space: start of a step, point of a stage, its slope, sum of the slopes
    double step;  // s
    int64_t steps;
    static constexpr auto fields = extended(Plant<T>::fields, "state(13), work points(4, s + 14), step, steps");

    // Positions in a point: body (13), work of the cables, winches (s).
    static constexpr int WORK = 13, WINCH = 14;

    CDPR_INLINE T* point(int64_t k) const { return points + k * (WINCH + plant.s); }
};

template <class T> CDPR_INLINE void gather(const Plant<T>& plant, T* point, int64_t size) {
    for (int64_t i = 0; i < 13; i++) point[i] = plant.body[i];
    point[13] = plant.cable_work[0];
    for (int64_t i = 14; i < size; i++) point[i] = plant.winch[i - 14];
}

template <class T> CDPR_INLINE void scatter(const T* point, Plant<T>& plant, int64_t size) {
    for (int64_t i = 0; i < 13; i++) plant.body[i] = point[i];
    plant.cable_work[0] = point[13];
    for (int64_t i = 14; i < size; i++) plant.winch[i - 14] = point[i];
}

// Write the time derivatives of body, work and winches at the present geometry and tensions; `start` is the point at
// the start of the step.
template <class T, class Anchors> inline void write_slopes(const Plant<T>& plant, PlatformDynamics<T>& dynamics,
                                                           const Anchors& anchors, T* start, T* slope) {
    T acceleration[6];
    dynamics.compute(plant);
    accelerate(plant, dynamics, acceleration);
    const Vector<T> velocity = vector(plant.body + 7);
    store(velocity, slope);
    store(turning(plant.attitude(), vector(plant.body + 10)), slope + 3);
    store(vector(acceleration), slope + 7);
    store(vector(acceleration + 3), slope + 10);
    T power = 0.0;
    if (plant.has_bent_cables())
        power = sum(power, 0, 6, [&](int64_t i) { return plant.beside[i] * plant.body[7 + i]; });
    slope[13] = difference(power, 0, plant.m, [&](int64_t i) { return plant.tension[i] * plant.rate[i]; });
    if constexpr (Anchors::moving)
        for (int64_t i = 0; i < plant.m; i++)
            slope[13] += plant.tension[i] * dot(direction(plant, i), anchors.velocity(i));
    const WinchStates<T> slopes = {slope + 14, plant.places}, before = {start + 14, plant.places};
    for (int64_t i = 0; i < plant.m; i++) {
        const bool stretches = plant.stretches(i);
        write_own_slopes(plant, i, slopes.own(i, stretches));
        if (!stretches) continue;
        write_span_slopes(plant, i, slopes.of_span(i, plant.chain(i)));
        slopes.unwound(i) = -plant.chain(i).per_turn(plant.unwound(i)) * plant.speed(i);
        slopes.speed(i) = winch_acceleration(plant, i, before.speed(i));
    }
}

// Stop the drums that a brake has brought to rest since `start`, the point at the start of the step.
template <class T> CDPR_INLINE void stop_braked_drums(Plant<T>& plant, T* start) {
    const WinchStates<T> before = {start + 14, plant.places};
    for (int64_t i = 0; i < plant.m; i++)
        if (plant.stretches(i)) plant.speed(i) = stopped_by_brake(plant, i, before.speed(i), plant.speed(i));
}

// Advance body, winches and work by one step. The plant is settled at its start: the first stage is already evaluated.
template <class T, class Anchors>
inline void advance(WinchRungeKutta<T>& problem, PlatformDynamics<T>& dynamics, Anchors& anchors) {
    Plant<T>& plant = problem.plant;
    T *start = problem.point(0), *point = problem.point(1), *slope = problem.point(2), *total = problem.point(3);
    const int64_t size = 14 + plant.s;
    gather(plant, start, size);
    for (int64_t i = 0; i < size; i++) total[i] = 0.0;
    double since = 0.0;
    for (int stage = 0; stage < STAGES; stage++) {
        if (stage > 0) {
            scatter(point, plant, size);
            stop_braked_drums(plant, start);
            anchors.place(since);
            place_cables(plant, anchors);
            dynamics.known = false;
            write_tensions(plant, dynamics, anchors);
        }
        write_slopes(plant, dynamics, anchors, start, slope);
        since = reach(stage, problem.step);
        const T share = weight(stage), c = since;
        for (int64_t i = 0; i < size; i++) {
            total[i] = total[i] + share * slope[i];
            point[i] = start[i] + c * slope[i];
        }
    }
    const T c = problem.step / 6.0;
    for (int64_t i = 0; i < size; i++) point[i] = start[i] + c * total[i];
    store(normalised(quaternion(point + 3)), point + 3);
    scatter(point, plant, size);
    stop_braked_drums(plant, start);
    // The work is integrated here: nothing is left for `settle` to add.
    for (int64_t i = 0; i < plant.m; i++) plant.tension[i] = 0.0;
    for (int64_t i = 0; i < 6; i++) plant.beside[i] = 0.0;
    anchors.complete_step();
}

// Advance by n steps, then write the platform's `state`.
template <class T, class Anchors> inline int winch_runge_kutta_with(WinchRungeKutta<T>& problem, Anchors& anchors) {
    Plant<T>& plant = problem.plant;
    for (int64_t k = 0; k < problem.steps; k++) {
        PlatformDynamics<T> dynamics;
        settle(plant, dynamics, anchors);  // at the start of the winches, their states are known only then
        advance(problem, dynamics, anchors);
    }
    PlatformDynamics<T> dynamics;
    settle(plant, dynamics, anchors);
    to_platform(plant.offset, plant.body, problem.state);
    return 0;
}

template <class T> inline int winch_runge_kutta(WinchRungeKutta<T>& problem) {
    RestingAnchors anchors;
    return winch_runge_kutta_with(problem, anchors);
}

}  // namespace cdpr::CDPR_TARGET
