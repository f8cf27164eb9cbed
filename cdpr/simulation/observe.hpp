// Observation of the plant at a new sample: cable geometry, energies, and faults. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/energy.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/proportional_derivative.hpp>

namespace cdpr::CDPR_TARGET {

// Impossible states; numbered as cdpr.simulation.faults.
enum Fault { NO_FAULT, NOT_FINITE, NO_UNIT, TOO_FAST, JUMPED, NO_LENGTH, NO_LENGTH_NOMINAL };

// Faster than any cable robot by two orders: the run has diverged.
constexpr double SPEED_MAX = 1e3;          // m/s
constexpr double ANGULAR_SPEED_MAX = 1e4;  // rad/s

// Round-off dominates the direction of a shorter cable, m.
constexpr double LENGTH_MIN = 1e-9;

// Engines normalise quaternions at each step; this is far above round-off, far below a usable attitude.
constexpr double NORM_TOLERANCE = 1e-6;

// A step of the pose may differ from the velocity after it by the largest possible acceleration times this factor, for
// schemes that do not know the velocity in between; plus round-off and errors of attitude maps.
constexpr double JUMP_FACTOR = 2.0;
constexpr double JUMP_SPEED = 1e-6;  // m/s and rad/s

template <class T> struct Observation {
    const T* lines;     // (m, w), as in Geometry
    const T* inertial;  // (13), `Robot.inertial`
    const T* gravity;   // (3), m/s^2, world
    const T* bounds;    // (7), as in Bounds
    const T* live;      // (13), state of the plant: position, m; quaternion; velocity, m/s; angular velocity, rad/s
    const T* external;  // (6), wrench in the previous period, N and N m, about the platform's origin, world axes
    const T* highest;   // (m), N: upper bound of each tension; for ideal cables the tension
    T* state;           // (13), as `live`: of the previous sample, then of this one
    T* matrix;          // (6, m), wrench matrix
    T* length;          // (m), m: of the previous sample, then of this one
    T* rate;            // (m), m/s
    T* energies;        // (4), J: kinetic, potential, and works so far of ideal cables and of the external wrench
    T* before;          // (m), m, work space: the previous lengths
    double period;      // control period, s; 0 resets the works
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), inertial(13), gravity(3), bounds(7), live(13), external(6), highest(m), both state(13), "
        "both matrix(6, m), both length(m), both rate(m), both energies(4), work before(m), period, m, w";
};

// Limits of the accelerations of the platform.
template <class T> struct Bounds {
    T inverse_mass;     // 1/kg
    T weight;           // |gravity|, m/s^2
    T arm;              // distance of the centre of mass from the origin, m
    T reach;            // largest distance of a cable's anchor or the origin from the centre of mass, m
    T inverse_inertia;  // 1 / smallest principal moment, 1/(kg m^2)
    T gyroscopic;       // largest ratio of the gyroscopic angular acceleration to the squared angular speed
    Truth<T> swings;    // whether the force that holds the origin turns the platform, as in a pendulum
};

template <class T> CDPR_INLINE Bounds<T> acceleration_bounds(const T* b) {
    return {b[0], b[1], b[2], b[3], b[4], b[5], b[6] > T(0.0)};
}

// Motion of the plant since the previous sample; all but `turn` squared.
template <class T> struct Motion {
    Vector<T> turn;   // rotation vector, rad
    T speed;          // m^2/s^2
    T spin;           // rad^2/s^2, the larger one of both samples, by axis
    T jump, twist;    // m^2, rad^2: motion that the velocities do not explain
    T force, moment;  // of the external wrench, N^2 and (N m)^2
};

template <class T> CDPR_INLINE Motion<T> motion_since(const Observation<T>& plant) {
    const T *live = plant.live, *state = plant.state, period = plant.period;
    const Vector<T> turn = attitude_error(state, live);
    const T turned[] = {turn.x, turn.y, turn.z};
    Motion<T> found = {turn, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < 3; i++) {
        const T v = live[7 + i], omega = live[10 + i], past = state[10 + i];
        const T moved = live[i] - state[i] - period * v, twisted = turned[i] - period * omega;
        found.speed += v * v;
        found.spin += larger(omega * omega, past * past);
        found.jump += moved * moved;
        found.twist += twisted * twisted;
        found.force += plant.external[i] * plant.external[i];
        found.moment += plant.external[3 + i] * plant.external[3 + i];
    }
    return found;
}

template <class T> struct Accelerations {
    T linear, angular;  // m/s^2, rad/s^2
};

// Return the largest accelerations of the platform that cables, external wrench and weight can cause.
template <class T>
CDPR_INLINE Accelerations<T> largest_accelerations(const Observation<T>& plant, const Motion<T>& motion) {
    const Bounds<T> bounds = acceleration_bounds(plant.bounds);
    T pull = square_root(motion.force);
    for (int64_t i = 0; i < plant.m; i++) pull += absolute(plant.highest[i]);
    T angular =
        (bounds.reach * pull + square_root(motion.moment)) * bounds.inverse_inertia + bounds.gyroscopic * motion.spin;
    T central = pull * bounds.inverse_mass + bounds.weight;  // of the centre of mass
    if (any(bounds.swings)) {
        // Gauss's principle: the constrained mass central^2 + angular inertia angular does not exceed the free one.
        const T ratio = bounds.inverse_inertia / bounds.inverse_mass;  // mass / smallest principal moment
        const T whole = central + bounds.arm * motion.spin;
        const T free = ratio * (whole * whole) + (1.0 + bounds.gyroscopic) * (angular * angular);
        angular = select(bounds.swings, square_root(free), angular);
        central = select(bounds.swings, square_root(free / ratio), central);
    }
    return {central + bounds.arm * (angular + motion.spin), angular};
}

// Return the fault of the motion, except states that are not finite.
template <class T> CDPR_INLINE T motion_fault(const Observation<T>& plant, const Motion<T>& motion) {
    const T period = plant.period;
    const Accelerations<T> most = largest_accelerations(plant, motion);
    const Truth<T> jumped = square_root(motion.jump) > period * (JUMP_SPEED + JUMP_FACTOR * period * most.linear);
    // A rotation by more than pi appears as its shorter equivalent: only smaller ones can be compared.
    const Truth<T> comparable = period * square_root(motion.spin) < T(1.0);
    const Truth<T> spun = square_root(motion.twist) > period * (JUMP_SPEED + JUMP_FACTOR * period * most.angular);
    const Truth<T> fast =
        (motion.speed > T(SPEED_MAX * SPEED_MAX)) | (motion.spin > T(ANGULAR_SPEED_MAX * ANGULAR_SPEED_MAX));
    const Quaternion<T> q = quaternion(plant.live + 3);
    const T stretch = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1.0;
    const T norm = select(absolute(stretch) > T(NORM_TOLERANCE), T(double(NO_UNIT)), T(double(NO_FAULT)));
    return select(fast, T(double(TOO_FAST)), select(jumped | (comparable & spun), T(double(JUMPED)), norm));
}

// Write state and energies of the lanes without a fault.
template <class T>
CDPR_INLINE void accept_sample(Observation<T>& plant, Truth<T> faulty, Vector<T> turn, T cable_work) {
    const Energy<T> now = energy<T>({plant.inertial}, vector(plant.gravity), plant.live);
    T* energies = plant.energies;
    T cables = energies[2] + cable_work;
    T external = energies[3] + external_work(plant.external, plant.period, turn, plant.state, plant.live);
    if (plant.period == 0.0) cables = external = 0.0;
    energies[0] = select(faulty, energies[0], now.kinetic);
    energies[1] = select(faulty, energies[1], now.potential);
    energies[2] = select(faulty, energies[2], cables);
    energies[3] = select(faulty, energies[3], external);
    for (int i = 0; i < 13; i++) plant.state[i] = select(faulty, plant.state[i], plant.live[i]);
}

// Return a Fault; for lanes, the bits of faulty ones. After a fault, state, lengths and energies are unchanged. The
// work of a held tension is exactly tension times shortening.
template <class T> inline int observe(Observation<T>& plant) {
    const int64_t m = plant.m;
    const T zero = sum(T(0.0), 0, 13, [&](int64_t i) { return 0.0 * plant.live[i]; });
    const Truth<T> finite = zero == T(0.0);
    const Motion<T> motion = motion_since(plant);
    T fault = motion_fault(plant, motion), cable_work = 0.0;
    for (int64_t i = 0; i < m; i++) {
        plant.before[i] = plant.length[i];
        cable_work += plant.highest[i] * plant.length[i];
    }
    if (any(finite)) {
        Geometry<T> cables = {plant.lines, plant.live, plant.matrix, plant.length, plant.rate, m, plant.w};
        if (const int refused = geometry(cables)) return refused;
    }
    for (int64_t i = 0; i < m; i++) {
        cable_work -= plant.highest[i] * plant.length[i];
        fault = select(plant.length[i] > T(LENGTH_MIN), fault, T(double(NO_LENGTH)));
    }
    fault = select(finite, fault, T(double(NOT_FINITE)));
    const Truth<T> faulty = fault != T(double(NO_FAULT));
    if (any(faulty))
        for (int64_t i = 0; i < m; i++) plant.length[i] = select(faulty, plant.before[i], plant.length[i]);
    if (!all(faulty)) accept_sample(plant, faulty, motion.turn, cable_work);
    return code(fault);
}

// Cable geometry of the nominal robot, which the controller uses.
template <class T> inline int observe_nominal(Geometry<T>& cables) {
    if (const int refused = geometry(cables)) return refused;
    T fault = double(NO_FAULT);
    for (int64_t i = 0; i < cables.m; i++)
        fault = select(cables.length[i] > T(LENGTH_MIN), fault, T(double(NO_LENGTH_NOMINAL)));
    return code(fault);
}

// Wrench of given tensions by the wrench matrix.
template <class T> struct Exertion {
    const T* matrix;   // (6, m)
    const T* tension;  // (m), N
    T* wrench;         // (6), N and N m
    int64_t m;
    static constexpr char fields[] = "matrix(6, m), tension(m), wrench(6), m";
};

template <class T> inline int exert(Exertion<T>& cables) {
    for (int64_t j = 0; j < 6; j++) {
        const T* row = cables.matrix + j * cables.m;
        cables.wrench[j] = sum(T(0.0), 0, cables.m, [&](int64_t i) { return row[i] * cables.tension[i]; });
    }
    return 0;
}

// The same with cables that sag.
template <class T> struct BentExertion {
    Exertion<T> cables;
    const T* bending;  // (6), N and N m, wrench of the cables minus that by the wrench matrix
    static constexpr auto fields = extended(Exertion<T>::fields, "bending(6)");
};

template <class T> inline int exert_bent(BentExertion<T>& problem) {
    exert(problem.cables);
    for (int64_t j = 0; j < 6; j++) problem.cables.wrench[j] = problem.cables.wrench[j] + problem.bending[j];
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
