// Winches of a plant: tensions, start, and the step of semi-implicit engines. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/platform_acceleration.hpp>

namespace cdpr::CDPR_TARGET {

// Return the tension at the winch per tension at the platform of cable i, which moves towards it at `speed`, m/s.
template <class T> CDPR_INLINE T friction_at(const Plant<T>& plant, int64_t i, T speed) {
    const CableRun<T> run = plant.run(i);
    return friction(plant.row_of_line(i), run.sine, run.cosine, speed);
}

// Write these for eight cables, which move at `speed`; return whether there are eight.
template <class T> CDPR_INLINE bool write_eight_frictions(Plant<T>&, const T*) { return false; }

#ifdef CDPR_LANES
template <> CDPR_INLINE bool write_eight_frictions<double>(Plant<double>& plant, const double* speed) {
    if (!are_eight_rubbing<double>(plant.lines, plant.w, plant.m)) return false;
    const EightRubbing eight(plant.lines);
    const Lanes sine = gather(plant.runs + 8, CableRun<double>::COUNT);
    const Lanes cosine = gather(plant.runs + 9, CableRun<double>::COUNT);
    scatter(friction(eight.at({}, {}), sine, cosine, gather(speed, 1)), plant.at_winch);
    return true;
}
#endif

// Write these for cables that stretch or for those that do not. The speed is that at which the winch pays out.
template <class T> inline void write_friction(Plant<T>& plant, bool stretching) {
    T* const speed = plant.mass;
    int64_t count = 0;
    for (int64_t i = 0; i < plant.m; i++) {
        if (plant.stretches(i) != stretching || !plant.rubs(i)) continue;
        speed[i] = stretching ? -plant.chain(i).per_turn(plant.unwound(i)) * plant.speed(i) : plant.rate[i];
        count++;
    }
    if (count == 0 || (count == plant.m && write_eight_frictions(plant, speed))) return;
    for (int64_t i = 0; i < plant.m; i++)
        if (plant.stretches(i) == stretching && plant.rubs(i)) plant.at_winch[i] = friction_at(plant, i, speed[i]);
}

// Write geometry and rates at `body`, and the friction that depends on these alone.
template <class T, class Anchors> inline void place_cables(Plant<T>& plant, const Anchors& anchors) {
    plant_geometry(plant);
    add_anchor_rates(plant, anchors);
    write_friction(plant, false);
}

// Write unwound lengths and speeds for constant stretch, and commanded tensions or lengths. The first command of a
// winch that takes rates is its length.
template <class T> inline void start_stretching_cable(Plant<T>& plant, Truth<T> fresh, int64_t i) {
    const ChainRow<T> row = plant.chain(i);
    const T command = plant.command[i];
    T unwound = command;
    if (command_of(row.winch_kind()) == TENSION_COMMAND) {
        const T tension = plant.rubs(i) ? command / friction_at(plant, i, plant.rate[i]) : command;
        unwound = unwound_length(row, plant.bent_span(i), plant.length[i], tension);
    }
    const T speed = -plant.rate[i] / row.per_turn(unwound);
    plant.unwound(i) = select(fresh, unwound, plant.unwound(i));
    plant.speed(i) = select(fresh, speed, plant.speed(i));
    T start[MOST_SPAN_STATES], *own = plant.states().of_span(i, row);
    span_start(row.span_kind(), row.span(), plant.length[i], plant.unwound(i), row.lowest(), start);
    for (int64_t j = 0; j < span_states(row.span_kind()); j++) own[j] = select(fresh, start[j], own[j]);
}

// Return the tension of cable i at its winch at the start, N.
template <class T> inline T start_tension(const Plant<T>& plant, int64_t i) {
    const ChainRow<T> row = plant.chain(i);
    if (command_of(row.winch_kind()) == TENSION_COMMAND) return plant.command[i];
    const T tension = tension_at(row, plant.bent_span(i), plant.length[i], plant.unwound(i));
    return plant.rubs(i) ? friction_at(plant, i, plant.rate[i]) * tension : tension;
}

// Write the states of the winches at their start.
template <class T> inline void start_winches(Plant<T>& plant, Truth<T> fresh) {
    for (int64_t i = 0; i < plant.m; i++) {
        if (plant.stretches(i)) start_stretching_cable(plant, fresh, i);
        const int64_t count = plant.own_count(i);
        T start[MOST_STATES], present[ChainRow<T>::NUMBERS], *own = plant.own(i);
        own_start(plant.chain(i).winch_kind(), plant.motion(i, start_tension(plant, i), present), start, count);
        for (int64_t j = 0; j < count; j++) own[j] = select(fresh, start[j], own[j]);
    }
}

// Write the tensions of bent cables at their winches, and into `beside` the difference of their forces from these.
template <class T> inline void bend(Plant<T>& plant) {
    Vector<T> force = {0.0, 0.0, 0.0}, moment = {0.0, 0.0, 0.0};
    for (int64_t i = 0; i < plant.m; i++) {
        const ChainRow<T> row = plant.chain(i);
        if (!bends(row.span_kind())) continue;
        const BentCable<T> end =
            bent_pull(row.span_kind(), plant.bent_span(i), plant.unwound(i), plant.stretching(i), row.lowest());
        plant.light[i] = end.tension;
        plant.tension[i] = end.tension;
        const Vector<T> u = direction(plant, i);
        const Vector<T> f = end.force - end.tension * u;
        force = force + f;
        moment = moment + cross(plant.run(i).lever, f);
    }
    store(force, plant.beside);
    store(moment, plant.beside + 3);
}

// Write the speeds of winches whose commands define them; not at their start, `fresh`.
template <class T> inline void prescribe_speeds(Plant<T>& plant, Truth<T> fresh) {
    for (int64_t i = 0; i < plant.m; i++) {
        const ChainRow<T> row = plant.chain(i);
        if (!plant.stretches(i) || !prescribes_speed(row.winch_kind())) continue;
        T present[ChainRow<T>::NUMBERS];
        const T wanted = prescribed_speed(row.winch(plant.unwound(i), present), plant.command[i]);
        const T speed = select(plant.unpowered(i), T(0.0), wanted);
        plant.speed(i) = select(fresh, plant.speed(i), speed);
    }
}

// Write tensions without the drums' inertia, and that inertia along the cables; return whether there is any.
template <class T, class Anchors> inline bool write_light_tensions(Plant<T>& plant, const Anchors& anchors) {
    bool heavy = false;
    for (int64_t i = 0; i < plant.m; i++) {
        const ChainRow<T> row = plant.chain(i);
        WinchTension<T> own = {0.0, 0.0};
        if (!plant.stretches(i)) {
            own = row.held(plant.own(i), plant.command[i], plant.length[i], plant.rate[i],
                           is_heavy(row.winch_kind()) ? length_acceleration(plant, anchors, i) : T(0.0));
            if (plant.rubs(i)) own = {own.tension / plant.at_winch[i], own.mass / plant.at_winch[i]};
        } else if (!bends(row.span_kind())) {
            own.tension = pull(row.span_kind(), plant.span_motion(i), row.lowest());
        }
        plant.light[i] = own.tension;
        plant.mass[i] = own.mass;
        plant.tension[i] = own.tension;
        heavy = heavy || any(own.mass != T(0.0));
    }
    if (plant.has_bent_cables()) bend(plant);
    return heavy;
}

// Write the tensions, and the applied wrench of these and the external one, at the pose of the present geometry.
template <class T, class Anchors = RestingAnchors>
inline void write_tensions(Plant<T>& plant, PlatformDynamics<T>& dynamics, const Anchors& anchors = Anchors()) {
    if (plant.s > 0) {
        const Truth<T> fresh = plant.winch[0] != plant.winch[0];
        if (any(fresh)) start_winches(plant, fresh);
        prescribe_speeds(plant, fresh);
    }
    write_friction(plant, true);
    if (write_light_tensions(plant, anchors)) share_inertia(plant, dynamics);
    apply(plant);
    for (int64_t i = 0; i < plant.m; i++) {
        const T size = absolute(plant.tension[i]);
        plant.highest[i] = select(size > plant.highest[i], size, plant.highest[i]);
    }
}

// Return the work, J, of `beside` on the way from `place` to `body`, and set the place.
template <class T> inline T work_of_bent_cables(const Plant<T>& plant) {
    const Vector<T> moved = vector(plant.body) - vector(plant.place);
    const Vector<T> turned = logarithm(multiply(plant.attitude(), conjugate(quaternion(plant.place + 3))));
    const Vector<T> force = vector(plant.beside), moment = vector(plant.beside + 3);
    T work = 0.0;
    work = work + (force.x * moved.x + moment.x * turned.x);
    work = work + (force.y * moved.y + moment.y * turned.y);
    work = work + (force.z * moved.z + moment.z * turned.z);
    for (int64_t i = 0; i < 7; i++) plant.place[i] = plant.body[i];
    return work;
}

// Add the work of the last tensions that is not in the shortening of their cables, due to the motion of the anchors
// since then, by the trapezoidal rule.
template <class T, class Anchors> inline void add_work_of_anchors(Plant<T>& plant, Anchors& anchors) {
    if constexpr (Anchors::moving) {
        T* const past = anchors.own.past;
        const T half = 0.5 * (anchors.now - past[plant.m]);
        for (int64_t i = 0; i < plant.m; i++) {
            const T along = dot(direction(plant, i), anchors.velocity(i));
            plant.cable_work[0] += half * plant.tension[i] * (past[i] + along);
            past[i] = along;
        }
        past[plant.m] = anchors.now;
    }
}

// Write geometry, tensions and applied wrench at `body`; add the work of the last tensions on the way there. `dynamics`
// is that of the platform there, if known.
template <class T, class Anchors> inline void settle(Plant<T>& plant, PlatformDynamics<T>& dynamics, Anchors& anchors) {
    T* before = plant.light;
    for (int64_t i = 0; i < plant.m; i++) before[i] = plant.length[i];
    anchors.place(0.0);
    if (is_placed<T, Anchors>(plant))
        for (int64_t i = 0; i < plant.m; i++) plant.length[i] = plant.run(i).length();
    else
        place_cables(plant, anchors);
    plant.cable_work[0] = sum(plant.cable_work[0], 0, plant.m,
                              [&](int64_t i) { return plant.tension[i] * (before[i] - plant.length[i]); });
    if (plant.has_bent_cables()) plant.cable_work[0] = plant.cable_work[0] + work_of_bent_cables(plant);
    add_work_of_anchors(plant, anchors);
    write_tensions(plant, dynamics, anchors);
}

// Return the acceleration of a drum without power under the tension of its cable and dry friction of its brake, which
// holds a drum at rest up to the brake's torque (`cdpr.cables.brake`); `speed` is that at the start of the step, rad/s.
template <class T> CDPR_INLINE T braked_acceleration(const Plant<T>& plant, int64_t i, T speed) {
    T present[ChainRow<T>::NUMBERS];
    const WinchMotion<T> motion = plant.motion(i, plant.tension_at_winch(i), present);
    const T free = Drum::drum_acceleration(motion.numbers, T(0.0), motion.tension, motion.speed);
    const T brake = plant.brakes[i] / motion.numbers[Drum::INERTIA];
    const T beyond = larger(absolute(free) - brake, T(0.0));
    const T started = select(free < T(0.0), -beyond, beyond);
    return select(speed == T(0.0), started, free - select(speed < T(0.0), -brake, brake));
}

// Return the acceleration of winch i under the tension of its cable; `speed` is that at the start of the step.
template <class T> CDPR_INLINE T winch_acceleration(const Plant<T>& plant, int64_t i, T speed) {
    const T kind = plant.chain(i).winch_kind();
    T present[ChainRow<T>::NUMBERS];
    const T powered = drum_acceleration(kind, plant.motion(i, plant.tension_at_winch(i), present));
    const Truth<T> off = plant.unpowered(i);
    if (!any(off) || !turns_freely(kind)) return powered;
    return select(off, braked_acceleration(plant, i, speed), powered);
}

// Stop drums that a brake has brought to rest: those whose direction differs from that at the start of the step.
template <class T> CDPR_INLINE T stopped_by_brake(const Plant<T>& plant, int64_t i, T before, T after) {
    const Truth<T> off = plant.unpowered(i);
    if (!any(off)) return after;
    return select(off & (plant.brakes[i] > T(0.0)) & (before * after < T(0.0)), T(0.0), after);
}

// Write the time derivatives of the own states of winch i under the tension of its cable.
template <class T> CDPR_INLINE void write_own_slopes(const Plant<T>& plant, int64_t i, T* slope) {
    T present[ChainRow<T>::NUMBERS];
    const WinchMotion<T> motion = plant.motion(i, plant.tension_at_winch(i), present);
    own_slopes(plant.chain(i).winch_kind(), motion, slope, plant.own_count(i));
}

// Write those of the states of span i, which stretches.
template <class T> CDPR_INLINE void write_span_slopes(const Plant<T>& plant, int64_t i, T* slope) {
    const ChainRow<T> row = plant.chain(i);
    if (span_states(row.span_kind())) span_slopes(row.span_kind(), plant.span_motion(i), row.lowest(), slope);
}

// Return the torque of the motor of winch i about the drum's axis, N m: 0 without power, NaN for a winch without one.
template <class T> CDPR_INLINE T present_torque(const Plant<T>& plant, int64_t i, WinchMotion<T> motion) {
    const T torque = motor_torque(plant.chain(i).winch_kind(), motion);
    const Truth<T> off = plant.unpowered(i);
    return any(off) ? select(off & (torque == torque), T(0.0), torque) : torque;
}

// Unwound lengths, speeds and torques of winches at the last settled `body`.
struct WinchReading {
    Plant<double> plant;
    double* unwound;    // (m), m; NaN before the start
    double* unwinding;  // (m), m/s
    double* torque;     // (m), N m, of the motor about the drum's axis; NaN for a winch without one
    static constexpr auto fields = extended(Plant<double>::fields, "unwound(m), unwinding(m), torque(m)");
};

inline int read_winches(WinchReading& p) {
    const Plant<double>& plant = p.plant;
    for (int64_t i = 0; i < plant.m; i++) {
        double present[ChainRow<double>::NUMBERS];
        const WinchMotion<double> motion = plant.motion(i, plant.tension_at_winch(i), present);
        p.unwound[i] = motion.unwound;
        p.unwinding[i] = -motion.numbers[0] * motion.speed;
        p.torque[i] = present_torque(plant, i, motion);
    }
    return 0;
}

// Tensions at the winches at the last settled `body`.
template <class T> struct ExitReading {
    Plant<T> plant;
    T* pulled;  // (m), N
    static constexpr auto fields = extended(Plant<T>::fields, "pulled(m)");
};

template <class T> inline int read_winch_tensions(ExitReading<T>& p) {
    for (int64_t i = 0; i < p.plant.m; i++) p.pulled[i] = p.plant.tension_at_winch(i);
    return 0;
}

// Drums at the last settled `body`; NaN for cables without one.
template <class T> struct DrumReading {
    Plant<T> plant;
    T* angle;   // (m), rad, 0 at the home pose
    T* speed;   // (m), rad/s
    T* torque;  // (m), N m, of the motor about the drum's axis; NaN for an ideal drive
    T* power;   // (m), W, of that torque
    static constexpr auto fields = extended(Plant<T>::fields, "angle(m), speed(m), torque(m), power(m)");
};

template <class T> inline int read_drums(DrumReading<T>& p) {
    const Plant<T>& plant = p.plant;
    for (int64_t i = 0; i < plant.m; i++) {
        const ChainRow<T> row = plant.chain(i);
        T present[ChainRow<T>::NUMBERS];
        const WinchMotion<T> motion = plant.motion(i, plant.tension_at_winch(i), present);
        p.torque[i] = present_torque(plant, i, motion);
        p.power[i] = p.torque[i] * motion.speed;
        p.angle[i] = row.angle(motion.unwound);
        p.speed[i] = select(p.angle[i] == p.angle[i], motion.speed, T(NOT_A_NUMBER));
    }
    return 0;
}

// Tensions, work and applied wrench at `body`.
template <class T, class Anchors> inline int settle_winches_with(Plant<T>& plant, Anchors& anchors) {
    PlatformDynamics<T> dynamics;
    settle(plant, dynamics, anchors);
    return 0;
}

template <class T> inline int settle_winches(Plant<T>& plant) {
    RestingAnchors anchors;
    return settle_winches_with(plant, anchors);
}

// Unwound lengths, and the wrench of bent cables less that of their tensions along their chords, about the platform's
// origin, after `settle_winches`.
template <class T> struct BentReadings {
    Plant<T> plant;
    T* unstretched;  // (m), m; of cables that do not stretch, their lengths
    T* bending;      // (6), N and N m
    static constexpr auto fields = extended(Plant<T>::fields, "unstretched(m), bending(6)");
};

template <class T> inline int read_bent_cables(BentReadings<T>& problem) {
    const Plant<T>& plant = problem.plant;
    for (int64_t i = 0; i < plant.m; i++)
        problem.unstretched[i] = plant.stretches(i) ? plant.unwound(i) : plant.length[i];
    const Vector<T> force = vector(plant.beside), lever = rotate(plant.attitude(), vector(plant.offset));
    store(force, problem.bending);
    store(vector(plant.beside + 3) + cross(lever, force), problem.bending + 3);
    return 0;
}

// `settle_winches`, then a step of the winches as in semi-implicit engines: own states, with them speeds, and with
// these unwound lengths; states of spans.
template <class T> struct WinchStep {
    Plant<T> plant;
    double step;  // s
    static constexpr auto fields = extended(Plant<T>::fields, "step");
};

template <class T, class Anchors> inline int step_winches_with(WinchStep<T>& problem, Anchors& anchors) {
    Plant<T>& plant = problem.plant;
    const T h = problem.step;
    PlatformDynamics<T> dynamics;
    settle(plant, dynamics, anchors);
    anchors.complete_step();
    for (int64_t i = 0; i < plant.m; i++) {
        T slope[MOST_STATES], *own = plant.own(i);
        write_own_slopes(plant, i, slope);
        for (int64_t j = 0; j < plant.own_count(i); j++) own[j] = own[j] + h * slope[j];
        if (!plant.stretches(i)) continue;
        T* const of_span = plant.states().of_span(i, plant.chain(i));
        write_span_slopes(plant, i, slope);
        for (int64_t j = 0; j < span_states(plant.chain(i).span_kind()); j++) of_span[j] = of_span[j] + h * slope[j];
        const T before = plant.speed(i), after = before + h * winch_acceleration(plant, i, before);
        plant.speed(i) = stopped_by_brake(plant, i, before, after);
        plant.unwound(i) = plant.unwound(i) - h * plant.chain(i).per_turn(plant.unwound(i)) * plant.speed(i);
    }
    return 0;
}

template <class T> inline int step_winches(WinchStep<T>& problem) {
    RestingAnchors anchors;
    return step_winches_with(problem, anchors);
}

}  // namespace cdpr::CDPR_TARGET
