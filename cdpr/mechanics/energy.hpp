// Energy of the platform, and the work done on it. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/inverse_dynamics.hpp>

namespace cdpr::CDPR_TARGET {

// With G the centre of mass: kinetic m |v_G|^2 / 2 + omega . I omega / 2, J; potential -m g . p_G, which is 0 at the
// world's origin, J.
template <class T> struct Energy {
    T kinetic, potential;
};

// Return the energy at `state` (13).
template <class T> CDPR_INLINE Energy<T> energy(Inertial<T> body, Vector<T> gravity, const T* state) {
    const Quaternion<T> q = quaternion(state + 3);
    const Vector<T> omega = vector(state + 10), r = body.lever(q);
    const Vector<T> v = vector(state + 7) + cross(omega, r), w = rotate(conjugate(q), omega);
    const T height = dot(gravity, vector(state) + r);
    return {0.5 * (body.mass() * dot(v, v) + dot(w, body.times(w))), -body.mass() * height};
}

// Return the work, J, of a constant wrench (6) about the origin, N and N m, over a period, s, between two states (13).
//
// That of the force is exact. That of the moment is moment . integral of omega, and that integral is the rotation
// vector `turn` of the period plus period^2 / 12 omega_0 x omega_1 (second term of the Magnus expansion, with omega
// linear in time): exact about a fixed axis, else of fourth order; the rotation vector alone would be of second.
template <class T>
CDPR_INLINE T external_work(const T* wrench, double period, Vector<T> turn, const T* before, const T* after) {
    const Vector<T> moved = vector(after) - vector(before), drift = cross(vector(before + 10), vector(after + 10));
    const Vector<T> turned = turn + T(period * period / 12.0) * drift;
    T work = 0.0;
    work = work + wrench[0] * moved.x;
    work = work + wrench[3] * turned.x;
    work = work + wrench[1] * moved.y;
    work = work + wrench[4] * turned.y;
    work = work + wrench[2] * moved.z;
    work = work + wrench[5] * turned.z;
    return work;
}

template <class T> struct PlatformEnergy {
    const T* inertial;  // (13), as of Inertial
    const T* gravity;   // (3), m/s^2, world
    const T* state;     // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    T* energies;        // (2), J: kinetic and potential
    static constexpr char fields[] = "inertial(13), gravity(3), state(13), energies(2)";
};

template <class T> inline int platform_energy(PlatformEnergy<T>& platform) {
    const Energy<T> found = energy<T>({platform.inertial}, vector(platform.gravity), platform.state);
    platform.energies[0] = found.kinetic;
    platform.energies[1] = found.potential;
    return 0;
}

template <class T> struct ExternalWork {
    const T* wrench;  // (6), N and N m, about the platform's origin, world axes
    const T* turn;    // (3), rad, rotation vector between the states
    const T* before;  // (13), state
    const T* after;   // (13), state
    T* work;          // (1), J
    double period;    // s
    static constexpr char fields[] = "wrench(6), turn(3), before(13), after(13), work(1), period";
};

template <class T> inline int external_work(ExternalWork<T>& p) {
    *p.work = external_work(p.wrench, p.period, vector(p.turn), p.before, p.after);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
