// Clearance of cables that sag. SPDX-License-Identifier: Apache-2.0
//
// The rules of clearance.hpp with the axes of curves.hpp. Distances have an error of at most CURVE_ERROR per pair;
// those of cables that do not sag have the bits of clearance.hpp.
#pragma once

#include <cdpr/mechanics/clearance.hpp>
#include <cdpr/mechanics/curves.hpp>

namespace cdpr::CDPR_TARGET {

// Bodies with cables that may sag; the first fields of the operations below.
struct SaggingBodies {
    Bodies bodies;
    const double* chains;   // (m, 33), as in ChainRow
    const double* gravity;  // (3), m/s^2, world
    double* axes;           // (m, 20), work space
    static constexpr auto fields = extended(Bodies::fields, "chains(m, 33), gravity(3), work axes(m, 20)");

    CDPR_INLINE CableAxis axis(int64_t i) const { return CableAxis(axes + AXIS * i); }
};

// Return the distance of the axes of two cables, as `axes_distance`, if it is below `limit`, else `limit`.
inline double curves_distance(const CableAxis& first, const CableAxis& second, bool apart, bool on_platform,
                              double limit) {
    if (apart)
        return least_distance(first, second, limit, [](const AxisPiece& a, const AxisPiece& b) {
            return between(a.end, a.start, b.end, b.start);
        });
    const auto from_end = [on_platform](const CableAxis& of, const CableAxis& axis, double most) {
        const Vector<double> x = on_platform ? of.exit : of.tip;
        return least_distance(axis, most,
                              [x](Vector<double> end, Vector<double> start) { return from_point(x, end, start); });
    };
    return from_end(second, first, from_end(first, second, limit));
}

// Return the smallest signed distance of an axis from a solid if it is below `limit`, else `limit`.
inline double curve_from_solid(Solid solid, const CableAxis& axis, double limit) {
    return least_distance(axis, limit,
                          [solid](Vector<double> end, Vector<double> start) { return from_solid(solid, end, start); });
}

// Return the clearance of a cable from its own platform, as `from_platform`. At an anchor on the surface, the tangent
// of the curve takes the place of the chord; a curve that enters the solid farther on has the negative of its depth.
inline double curve_from_platform(const Bodies& bodies, Solid solid, int64_t i, const CableAxis& axis, Vector<double> p,
                                  Quaternion<double> q) {
    const Quaternion<double> back = conjugate(q);
    if (!axis.curved) return from_platform(bodies, solid, i, rotate(back, axis.exit - p));
    const Vector<double> B = bodies.anchor(i), anchor = solid.local(B);
    const double outside = signed_distance(solid, anchor).distance;
    if (outside < -ON_SURFACE) return INFINITE;
    const auto nearest_to = [&](double limit) {
        return least_distance(axis, limit, [&](Vector<double> end, Vector<double> start) {
            return from_solid(solid, rotate(back, end - p), rotate(back, start - p));
        });
    };
    if (outside > ON_SURFACE) return nearest_to(INFINITE) - bodies.radius[i];
    const Vector<double> along = axis.along(0.0);
    const Vector<double> leaving = (length(axis.exit - axis.tip) / length(along)) * along;
    const double height = above(solid, anchor, solid.local(B + rotate(back, leaving)), ON_SURFACE);
    const double touching = -ON_SURFACE - CURVE_ERROR, deepest = height < 0.0 ? height : nearest_to(touching);
    return deepest < touching ? deepest : height;
}

// Return the least clearance at a pose (7): position, m, and quaternion, with unwound lengths (m), m.
inline Nearest<double> nearest_curves(const SaggingBodies& given, const double* pose, const double* unwound) {
    const Bodies& bodies = given.bodies;
    const int64_t m = bodies.m;
    const Vector<double> p = vector(pose), down = vector(given.gravity);
    const Quaternion<double> q = quaternion(pose + 3);
    for (int64_t i = 0; i < m; i++)
        write_axis(line(bodies.lines, bodies.w, i, p, q), chain_row(given.chains, i), down, unwound[i],
                   given.axes + AXIS * i);
    Nearest<double> least = {INFINITE, -1.0};
    for (int64_t i = 0; i < m; i++) {
        for (int64_t j = 0; j < i; j++) {
            const int64_t pair = bodies.pairs[i * m + j];
            const double thick = bodies.radius[i] + bodies.radius[j], limit = least.clearance + thick;
            if (pair == SAME || thick == GONE) continue;
            const bool on_platform = bodies.pairs[j * m + i] == SHARED;
            const double found = curves_distance(given.axis(i), given.axis(j), pair == APART, on_platform, limit);
            if (found < limit) least = {found - thick, double(j * m + i)};
        }
    }
    for (int64_t j = 0; j < bodies.p; j++) {
        for (int64_t i = 0; i < m; i++) {
            if (bodies.radius[i] == GONE) continue;
            const Solid solid = {bodies.platform + 11 * j, 11};
            const double value = curve_from_platform(bodies, solid, i, given.axis(i), p, q);
            if (value < least.clearance) least = {value, double(m * m + i)};
        }
    }
    for (int64_t j = 0; j < bodies.k; j++) {
        for (int64_t i = 0; i < m; i++) {
            const double limit = least.clearance + bodies.radius[i];
            if (bodies.radius[i] == GONE) continue;
            const double found = curve_from_solid(bodies.obstacle(j), given.axis(i), limit);
            if (found < limit) least = {found - bodies.radius[i], double(m * m + m + j * m + i)};
        }
    }
    return least;
}

struct SaggingClearances {
    SaggingBodies bodies;
    const double* poses;    // (count, 7), position, m, and quaternion
    const double* unwound;  // (count, m), m
    double* clearance;      // (count), m
    int64_t* which;         // (count), pair, as in Nearest
    int64_t count;
    static constexpr auto fields =
        extended(SaggingBodies::fields, "poses(count, 7), unwound(count, m), clearance(count), which(count), count");
};

inline int sagging_clearances(SaggingClearances& asked) {
    const Bodies& bodies = asked.bodies.bodies;
    if (!has_anchors<double>(bodies.w)) return BAD_INPUT;
    for (int64_t k = 0; k < asked.count; k++) {
        const Nearest<double> found = nearest_curves(asked.bodies, asked.poses + 7 * k, asked.unwound + bodies.m * k);
        asked.clearance[k] = found.clearance;
        asked.which[k] = static_cast<int64_t>(found.which);
    }
    return OK;
}

// Check whether unbroken cables that may sag are too near, for the loop.
struct SaggingTooNear {
    SaggingBodies bodies;   // radius: of the cables before any break
    const double* pose;     // (7), position, m, and quaternion
    const double* unwound;  // (m), m
    const double* gone;     // (m), s, times at which cables break; INFINITE for others
    double* present;        // (m), m, radii at this time
    double clearance;       // m, lower limit of the clearance
    double after;           // s, start of the check
    static constexpr auto fields =
        extended(SaggingBodies::fields, "pose(7), unwound(m), gone(m), present(m), clearance, after");
};

// Return 1 if they are too near, else 0.
inline int sagging_too_near(SaggingTooNear& watch, double time) {
    SaggingBodies now = watch.bodies;
    if (!has_anchors<double>(now.bodies.w)) return BAD_INPUT;
    now.bodies = unbroken(now.bodies, watch.gone, time, watch.present);
    if (time < watch.after) return 0;
    return nearest_curves(now, watch.pose, watch.unwound).clearance <= watch.clearance ? 1 : 0;
}

}  // namespace cdpr::CDPR_TARGET
