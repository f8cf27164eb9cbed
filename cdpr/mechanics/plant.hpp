// Platform with its cables and their winches: fields, geometry and applied wrench. SPDX-License-Identifier: Apache-2.0
//
// "The body" is the platform in the frame in which it is integrated (`cdpr.mechanics.body_frame`). World axes, SI
// units.
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/matrix.hpp>
#include <cdpr/mechanics/anchors.hpp>
#include <cdpr/mechanics/body_frame.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/same_bits.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

// Cable at the present pose: the lever of its anchor on the body, the chord from there to the exit, that chord's
// length, and the length of cable on the exit, m; sine and cosine of the angle of cable on the exit.
template <class T> struct CableRun {
    static constexpr int COUNT = 10;

    Vector<T> lever, chord;
    T chord_length, wrapped_length, sine, cosine;

    CDPR_INLINE T length() const { return chord_length + wrapped_length; }
};

template <class T> struct Plant {
    const T* chains;       // (m, 33), chain.hpp
    const T* lines;        // (m, w), w >= 6, geometry.hpp, B_i in the body frame
    const T* offset;       // (7), from the platform's origin to the body's, m, body axes, and the attitude between them
    const T* inertial;     // (13), as of Inertial, body frame
    const T* free;         // (6), 1 for each free row of a twist, 0 for directions blocked by a guide
    const T* gravity;      // (3), m/s^2
    const T* command;      // (m), of each winch: N, m or m/s
    const T* external;     // (6), wrench at the platform's origin, N and N m
    T* body;               // (13), state of the body
    T* winch;              // (s), state numbers of winches and spans, WinchStates; NaN before the start
    T* tension;            // (m), N
    T* highest;            // (m), largest size of each tension since the start, N
    T* length;             // (m), m
    T* cable_work;         // (1), of the cables on the platform since the start, J
    T* beside;             // (6), wrench of bent cables less that of their tensions along their chords
    T* place;              // (7), pose of the body at the last update of `cable_work`; only for plants with bent cables
    T* applied;            // (6), wrench of cables and `external` about the body's origin, N and N m
    T* rate;               // (m), m/s
    T* matrix;             // (6, m), W about the body's origin
    T* at_winch;           // (m), tension at each winch per tension at the platform
    T* runs;               // (m, 10), a CableRun of each
    T* light;              // (m), work space: tensions without the drums' inertia, N
    T* mass;               // (m), work space: that inertia along the cable, kg
    T* pulls;              // (m), work space: 1 for each taut cable, 0 for a slack one
    const int64_t* kinds;  // (m, 3), of winches, spans and exits as in `chains` and `lines`; the same in all lanes
    const int64_t* places;  // (m + 1), of the states of each winch in `winch`, and their number
    int64_t m;
    int64_t w;
    int64_t s;
    const T* brakes = nullptr;  // (m), N m, of winches without power: brake torque; negative with power; not in FMUs
    T* seen = nullptr;  // (13), the body at which geometry was last written; NaN after a change of lines; not in FMUs
    static constexpr char fields[] =
        "chains(m, 33), lines(m, w >= 6), offset(7), inertial(13), free(6), gravity(3), command(m), external(6), "
        "both body(13), both winch(s), both tension(m), both highest(m), both length(m), both cable_work(1), "
        "both beside(6), both place(7), applied(6), both rate(m), both matrix(6, m), both at_winch(m), both runs(m, "
        "10), "
        "work light(m), work mass(m), work pulls(m), kinds(m, 3), places(m + 1), m, w, s, "
        "brakes(m), both seen(13)";

    CDPR_INLINE ChainRow<T> chain(int64_t i) const { return chain_row(chains, i); }
    CDPR_INLINE Quaternion<T> attitude() const { return quaternion(body + 3); }
    CDPR_INLINE Matrix<T> W() const { return {matrix, m}; }
    CDPR_INLINE WinchStates<T> states() const { return {winch, places}; }
    CDPR_INLINE T& unwound(int64_t i) const { return states().unwound(i); }  // of a cable that stretches
    CDPR_INLINE T& speed(int64_t i) const { return states().speed(i); }      // of its winch
    CDPR_INLINE T* own(int64_t i) const { return states().own(i, stretches(i)); }
    CDPR_INLINE int64_t own_count(int64_t i) const { return states().own_count(i, chain(i)); }
    CDPR_INLINE SpanMotion<T> span_motion(int64_t i) const { return states().span(i, chain(i), length[i], rate[i]); }

    // Return the unwound length of cable i, m, and the speed of its winch; a cable that does not stretch moves it.
    CDPR_INLINE T unwound_or_length(int64_t i) const { return stretches(i) ? unwound(i) : length[i]; }
    CDPR_INLINE T winch_speed(int64_t i) const {
        if (stretches(i)) return speed(i);
        const T per_turn = chain(i).per_turn(length[i]);
        return select(per_turn == T(0.0), T(0.0), -rate[i] / per_turn);
    }

    // Return the motion of winch i under a tension of its cable, N. `present` (ChainRow::NUMBERS) is work space.
    CDPR_INLINE WinchMotion<T> motion(int64_t i, T pull, T* present) const {
        const T along = unwound_or_length(i), turning = winch_speed(i);
        const ChainRow<T> row = chain(i);
        return {row.winch(along, present), own(i), command[i], row.load(pull, turning), along, turning,
                row.transmission()};
    }

    // Return whether the motor of winch i has no power; its brake then holds the drum.
    CDPR_INLINE Truth<T> unpowered(int64_t i) const {
        return brakes != nullptr ? brakes[i] >= T(0.0) : T(0.0) > T(0.0);
    }

    // Return the rate of stretch of cable i, m/s.
    CDPR_INLINE T stretching(int64_t i) const { return rate[i] + chain(i).per_turn(unwound(i)) * speed(i); }

    CDPR_INLINE CableRun<T> run(int64_t i) const {
        const T* numbers = runs + CableRun<T>::COUNT * i;
        return {vector(numbers), vector(numbers + 3), numbers[6], numbers[7], numbers[8], numbers[9]};
    }

    CDPR_INLINE void keep(CableRun<T> run, int64_t i) const {
        T* numbers = runs + CableRun<T>::COUNT * i;
        store(run.lever, numbers);
        store(run.chord, numbers + 3);
        numbers[6] = run.chord_length;
        numbers[7] = run.wrapped_length;
        numbers[8] = run.sine;
        numbers[9] = run.cosine;
    }

    CDPR_INLINE BentSpan<T> bent_span(int64_t i) const {
        const CableRun<T> at = run(i);
        const Vector<T> exit = vector(body) + at.lever + at.chord;
        return {chain(i).span(), at.chord, at.wrapped_length, vector(gravity), vector(lines + i * w) - exit};
    }

    // Return the row of cable i, without its pose.
    CDPR_INLINE Line<T> row_of_line(int64_t i) const {
        const Vector<T> none = {0.0, 0.0, 0.0};
        return {lines + i * w, w, none, none, none};
    }

    // Return whether cable i loses tension on its exit, and its tension at the winch, N.
    CDPR_INLINE bool rubs(int64_t i) const { return kinds[3 * i + 2] != POINT && row_of_line(i).rubs(); }
    CDPR_INLINE T tension_at_winch(int64_t i) const { return rubs(i) ? at_winch[i] * tension[i] : tension[i]; }

    // Return whether cable i is elastic; whether some cable is bent.
    CDPR_INLINE bool stretches(int64_t i) const { return kinds[3 * i + 1] != INEXTENSIBLE; }
    CDPR_INLINE bool has_bent_cables() const {
        for (int64_t i = 0; i < m; i++)
            if (bends(chain(i).span_kind())) return true;
        return false;
    }
};

// Column of the wrench matrix, rate and run of a cable; formulas: geometry.hpp.
template <class T> struct PlantCable {
    Vector<T> u, moment;
    T rate;
    CableRun<T> run;
};

template <class T> CDPR_INLINE PlantCable<T> plant_cable(const Line<T>& cable, Vector<T> v, Vector<T> omega) {
    const ExitResult<T> exit = cable.lead();
    const Vector<T> l = cable.chord(exit.point);
    const T norm = length(l);
    const Vector<T> u = l / norm, moment = cross(cable.lever, u);
    return {u,
            moment,
            -dot(u, v) - dot(moment, omega),
            {cable.lever, l, norm, exit.wrapped_length, exit.sine, exit.cosine}};
}

// Write wrench matrix, lengths, rates and runs of eight cables on exits with friction.
template <class T> CDPR_INLINE void write_eight_rubbing(Plant<T>&, Vector<T>, Quaternion<T>, Vector<T>, Vector<T>) {}

#ifdef CDPR_LANES
CDPR_INLINE Vector<double> of_lane(Vector<Lanes> v, int i) { return {v.x.get(i), v.y.get(i), v.z.get(i)}; }

template <> CDPR_INLINE void write_eight_rubbing<double>(Plant<double>& plant, Vector<double> p, Quaternion<double> q,
                                                         Vector<double> v, Vector<double> omega) {
    using Eight = EightRubbing;
    const PlantCable<Lanes> cable = plant_cable(Eight(plant.lines).at(p, q), Eight::same(v), Eight::same(omega));
    const Vector<Lanes> u = cable.u, moment = cable.moment;
    const Lanes rows[] = {u.x, u.y, u.z, moment.x, moment.y, moment.z};
    for (int j = 0; j < 6; j++) scatter(rows[j], plant.matrix + j * WIDTH);
    scatter(cable.run.length(), plant.length);
    scatter(cable.rate, plant.rate);
    const CableRun<Lanes> run = cable.run;
    for (int i = 0; i < WIDTH; i++)
        plant.keep({of_lane(run.lever, i), of_lane(run.chord, i), run.chord_length.get(i), run.wrapped_length.get(i),
                    run.sine.get(i), run.cosine.get(i)},
                   i);
}
#endif

// Write wrench matrix, lengths, rates and runs at `body`.
template <class T> inline void plant_geometry(Plant<T>& plant) {
    const Vector<T> p = vector(plant.body), v = vector(plant.body + 7), omega = vector(plant.body + 10);
    const Quaternion<T> q = plant.attitude();
    for (int64_t j = 0; plant.seen != nullptr && j < 13; j++) plant.seen[j] = plant.body[j];
    if (are_eight_rubbing<T>(plant.lines, plant.w, plant.m)) return write_eight_rubbing(plant, p, q, v, omega);
    for (int64_t i = 0; i < plant.m; i++) {
        const PlantCable<T> cable = plant_cable(line(plant.lines, plant.w, i, p, q), v, omega);
        const Vector<T> u = cable.u, moment = cable.moment;
        const T column[6] = {u.x, u.y, u.z, moment.x, moment.y, moment.z};
        for (int64_t j = 0; j < 6; j++) plant.W()(j, i) = column[j];
        plant.length[i] = cable.run.length();
        plant.rate[i] = cable.rate;
        plant.keep(cable.run, i);
    }
}

// Return whether rates and `at_winch`, too, are those of `body`: only anchors at rest determine them by the body.
template <class T, class Anchors> CDPR_INLINE bool is_placed(const Plant<T>& plant) {
    return !Anchors::moving && plant.seen != nullptr && same_bits(plant.seen, plant.body, 13);
}

// Return u of cable i.
template <class T> CDPR_INLINE Vector<T> direction(const Plant<T>& plant, int64_t i) {
    return {plant.W()(0, i), plant.W()(1, i), plant.W()(2, i)};
}

// Add the motion of the anchors, u . A', to the rates.
template <class T, class Anchors> CDPR_INLINE void add_anchor_rates(Plant<T>& plant, const Anchors& anchors) {
    if constexpr (Anchors::moving)
        for (int64_t i = 0; i < plant.m; i++) plant.rate[i] += dot(direction(plant, i), anchors.velocity(i));
}

// Return the acceleration, m/s^2, of the length of cable i for a platform without acceleration: -W_i'^T twist, and
// (u . A')' of anchors that move.
template <class T, class Anchors>
CDPR_INLINE T length_acceleration(const Plant<T>& plant, const Anchors& anchors, int64_t i) {
    const Vector<T> p = vector(plant.body), v = vector(plant.body + 7), omega = vector(plant.body + 10);
    const CableRun<T> run = plant.run(i);
    const Line<T> cable = {plant.lines + i * plant.w, plant.w, p, run.lever, p + run.lever};
    const Vector<T> turning = cross(omega, run.lever), u = direction(plant, i);
    Vector<T> stretching = cable.velocity_of_exit(v + turning) - v - turning;
    if constexpr (Anchors::moving) stretching = stretching + anchors.velocity(i);
    const Vector<T> du = (stretching - dot(u, stretching) * u) / run.chord_length;
    const Vector<T> moment = cross(turning, u) + cross(run.lever, du);
    const T own =
        0.0 - du.x * v.x - du.y * v.y - du.z * v.z - moment.x * omega.x - moment.y * omega.y - moment.z * omega.z;
    if constexpr (Anchors::moving) return own + dot(du, anchors.velocity(i)) + dot(u, anchors.acceleration(i));
    return own;
}

// Write into `applied` the wrench of tensions, bent cables and the external wrench about the body's origin.
template <class T> inline void apply(const Plant<T>& plant) {
    Vector<T> force = {0.0, 0.0, 0.0}, moment = {0.0, 0.0, 0.0};
    for (int64_t i = 0; i < plant.m; i++) {
        const CableRun<T> run = plant.run(i);
        const Vector<T> f = (plant.tension[i] / run.chord_length) * run.chord;
        force = force + f;
        moment = moment + cross(run.lever, f);
    }
    store(with_external({force, moment}, plant.offset, plant.external, plant.attitude()), plant.applied);
    if (!plant.has_bent_cables()) return;
    for (int64_t j = 0; j < 6; j++) plant.applied[j] = plant.applied[j] + plant.beside[j];
}

}  // namespace cdpr::CDPR_TARGET
