// Clearance of cables from each other, from their own platform and from obstacles. SPDX-License-Identifier: Apache-2.0
//
// The axis of a cable is the segment from its exit to its anchor on the platform. A clearance is the distance of two
// axes less both radii, or of an axis from a solid less its radius: negative on contact. Rules for cables that share an
// anchor, and for a cable and its own platform: `cdpr.mechanics.clearance`.
#pragma once

#include <cdpr/lanes.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/solids.hpp>

namespace cdpr::CDPR_TARGET {

// An anchor this near to the surface of its platform, m, is on it: below the thickness of cables, above the rounding of
// files.
constexpr double ON_SURFACE = 1e-5;

// Radius of a broken cable: everything is infinitely far from it.
constexpr double GONE = -INFINITE;

// Distance of a pair of cables: between the cables, between the ends they do not share, or none.
enum PairKind { APART, SHARED, SAME };

// Bodies that may touch: the first fields of the operations on clearances.
struct Bodies {
    const double* lines;   // (m, w), w >= 6, as of geometry.hpp
    const double* radius;  // (m), m; GONE for a broken cable
    const int64_t*
        pairs;  // (m, m), PairKind of i and j < i; for cables with a common end, at (j, i) SHARED on the platform
    const double* platform;   // (p, 11), p of 0 or 1 solids (solids.hpp), platform axes
    const double* obstacles;  // (k, s), s >= 11, solids, world
    int64_t m;
    int64_t w;
    int64_t p;
    int64_t k;
    int64_t s;
    static constexpr char fields[] =
        "lines(m, w >= 6), radius(m), pairs(m, m), platform(p, 11), obstacles(k, s >= 11), m, w, p, k, s";

    CDPR_INLINE Vector<double> anchor(int64_t i) const { return vector(lines + i * w + Line<double>::PLATFORM); }
    CDPR_INLINE Solid obstacle(int64_t j) const { return {obstacles + j * s, s}; }
};

// Smallest clearance, m, and its pair: i m + j for two cables; from m^2 for its platform; from m^2 + m for obstacles;
// -1 for none.
template <class T> struct Nearest {
    T clearance;
    T which;
};

// Write both ends of a cable, (6), m, world.
CDPR_INLINE void write_ends(const Bodies& bodies, int64_t i, Vector<double> p, Quaternion<double> q, double* ends) {
    const Line<double> cable = line(bodies.lines, bodies.w, i, p, q);
    store(cable.exit(), ends);
    store(cable.tip, ends + 3);
}

#ifdef CDPR_LANES
// In eight poses; all exits are points.
CDPR_INLINE void write_ends(const Bodies& bodies, int64_t i, Vector<Lanes> p, Quaternion<Lanes> q, Lanes* ends) {
    const double* row = bodies.lines + i * bodies.w;
    const Vector<Lanes> lever = rotate(q, Vector<Lanes>{row[3], row[4], row[5]});
    store(Vector<Lanes>{row[0], row[1], row[2]}, ends);
    store(p + lever, ends + 3);
}
#endif

// Distance of the axes of two cables from their ends (6); with a common end, on the platform or on the frame, the
// distance of their other ends from each other's axis.
template <class T> CDPR_INLINE T axes_distance(const T* first, const T* second, bool apart, bool on_platform) {
    const Vector<T> E = vector(first), P = vector(first + 3), F = vector(second), Q = vector(second + 3);
    if (apart) return between(E, P, F, Q);
    if (on_platform) return smaller(from_point(E, F, Q), from_point(F, E, P));
    return smaller(from_point(P, F, Q), from_point(Q, E, P));
}

// Write both ends of all cables, (m, 6), m; return the nearest pair of cables.
template <class T> inline Nearest<T> nearest_cables(const Bodies& bodies, Vector<T> p, Quaternion<T> q, T* ends) {
    const int64_t m = bodies.m;
    for (int64_t i = 0; i < m; i++) write_ends(bodies, i, p, q, ends + 6 * i);
    Nearest<T> least = {INFINITE, -1.0};
    for (int64_t i = 0; i < m; i++) {
        for (int64_t j = 0; j < i; j++) {
            const int64_t pair = bodies.pairs[i * m + j];
            if (pair == SAME) continue;
            const bool on_platform = bodies.pairs[j * m + i] == SHARED;
            const T distance = axes_distance(ends + 6 * i, ends + 6 * j, pair == APART, on_platform);
            const T value = distance - (bodies.radius[i] + bodies.radius[j]);
            const Truth<T> nearer = value < least.clearance;
            least = {select(nearer, value, least.clearance), select(nearer, T(double(j * m + i)), least.which)};
        }
    }
    return least;
}

// Return the clearance of a cable from its own platform, INFINITE if its anchor is inside the shape.
inline double from_platform(const Bodies& bodies, Solid solid, int64_t i, Vector<double> end) {
    const Vector<double> anchor = solid.local(bodies.anchor(i));
    const double outside = signed_distance(solid, anchor).distance;
    if (outside < -ON_SURFACE) return INFINITE;
    if (outside <= ON_SURFACE) return above(solid, anchor, solid.local(end), ON_SURFACE);
    return from_solid(solid, bodies.anchor(i), end) - bodies.radius[i];
}

// Return the pair nearer than `least`: of cables, with known ends, and their platform or obstacles.
inline Nearest<double> nearest_solids(const Bodies& bodies, Vector<double> p, Quaternion<double> q, const double* ends,
                                      Nearest<double> least) {
    const int64_t m = bodies.m;
    for (int64_t j = 0; j < bodies.p; j++) {
        const Solid solid = {bodies.platform + 11 * j, 11};
        for (int64_t i = 0; i < m; i++) {
            if (bodies.radius[i] == GONE) continue;
            const Vector<double> end = rotate(conjugate(q), vector(ends + 6 * i) - p);
            const double value = from_platform(bodies, solid, i, end);
            if (value < least.clearance) least = {value, double(m * m + i)};
        }
    }
    for (int64_t j = 0; j < bodies.k; j++) {
        const Solid solid = bodies.obstacle(j);
        for (int64_t i = 0; i < m; i++) {
            const Vector<double> E = vector(ends + 6 * i), P = vector(ends + 6 * i + 3);
            if (beyond(solid, E, P) - bodies.radius[i] >= least.clearance) continue;
            const double value = from_solid(solid, E, P) - bodies.radius[i];
            if (value < least.clearance) least = {value, double(m * m + m + j * m + i)};
        }
    }
    return least;
}

// Return the least clearance at a pose (7): position, m, and quaternion. ends: (m, 6), work space.
inline Nearest<double> nearest(const Bodies& bodies, const double* pose, double* ends) {
    const Vector<double> p = vector(pose);
    const Quaternion<double> q = quaternion(pose + 3);
    return nearest_solids(bodies, p, q, ends, nearest_cables(bodies, p, q, ends));
}

// Bodies at a time, with cables before they break only; present: (m), m, their radii.
inline Bodies unbroken(Bodies bodies, const double* gone, double time, double* present) {
    for (int64_t i = 0; i < bodies.m; i++) present[i] = time < gone[i] ? bodies.radius[i] : GONE;
    bodies.radius = present;
    return bodies;
}

// Check whether unbroken cables are too near, for the loop.
struct TooNear {
    Bodies bodies;       // radius: of the cables before any break
    const double* pose;  // (7), position, m, and quaternion
    const double* gone;  // (m), s, times at which cables break; INFINITE for others
    double* present;     // (m), m, radii at this time
    double* ends;        // (m, 6), work space
    double clearance;    // m, lower limit of the clearance
    double after;        // s, start of the check
    static constexpr auto fields =
        extended(Bodies::fields, "pose(7), gone(m), present(m), work ends(m, 6), clearance, after");
};

// Return 1 if they are too near, else 0.
inline int too_near(TooNear& watch, double time) {
    if (!has_anchors<double>(watch.bodies.w)) return BAD_INPUT;
    const Bodies now = unbroken(watch.bodies, watch.gone, time, watch.present);
    if (time < watch.after) return 0;
    return nearest(now, watch.pose, watch.ends).clearance <= watch.clearance ? 1 : 0;
}

}  // namespace cdpr::CDPR_TARGET
