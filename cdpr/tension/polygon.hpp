// Admissible distributions of a robot with one or two redundant cables. SPDX-License-Identifier: Apache-2.0
//
// { x : low <= c + N x <= high }, N (m, r): for r = 1 an interval, for r = 2 a convex polygon (Mikelsons, Bruckmann,
// Schramm and Hiller, ICRA 2008; Gouttefarde, Lamaury, Reichert and Bruckmann, IEEE Trans. Robotics 31, 2015). Both
// coordinates are in N. Limits must be finite.
#pragma once

#include <cdpr/tension/polytope.hpp>

namespace cdpr::CDPR_TARGET {

// A limit counts as kept within this share of the largest tension or limit: some hundred times the round-off of
// clipping, to keep sets without interior (a segment, a point).
constexpr double CLIPPING_TOLERANCE = 1e-12;

inline double clipping_tolerance(const Polytope<double>& set) {
    double largest = 0.0;
    for (int64_t i = 0; i < set.m; i++)
        largest = larger(larger(larger(largest, absolute(set.center[i])), absolute(set.low[i])), absolute(set.high[i]));
    return CLIPPING_TOLERANCE * largest;
}

// Return whether a cable independent of x is within its limits.
CDPR_INLINE bool within(const Polytope<double>& set, int64_t i, double tolerance) {
    return set.low[i] - tolerance <= set.center[i] && set.center[i] <= set.high[i] + tolerance;
}

// Write the ends of the interval, ends[0] <= ends[1]; return their number: 0 if it is empty, 1 for a point (written
// twice), 2.
inline int clip_interval(const Polytope<double>& set, double* ends) {
    const double tolerance = clipping_tolerance(set);
    ends[0] = -INFINITE;
    ends[1] = INFINITE;
    double lower = 1.0, upper = 1.0;  // |N| of the cables that determine the ends
    for (int64_t i = 0; i < set.m; i++) {
        const double g = set.N(i, 0);
        if (g == 0.0) {  // x does not change this cable
            if (!within(set, i, tolerance)) return 0;
            continue;
        }
        const double at_low = (set.low[i] - set.center[i]) / g, at_high = (set.high[i] - set.center[i]) / g;
        const double a = g < 0.0 ? at_high : at_low, b = g < 0.0 ? at_low : at_high;
        if (a > ends[0]) {
            ends[0] = a;
            lower = absolute(g);
        }
        if (b < ends[1]) {
            ends[1] = b;
            upper = absolute(g);
        }
    }
    if (!finite(ends[1] - ends[0])) return 0;  // x changes no cable, or the input is not finite
    if (ends[1] - ends[0] > tolerance) return 2;
    // Between two conflicting limits, weighted so that both are violated, if at all, by the same force.
    const double share = upper / (lower + upper), overlap = ends[0] - ends[1];
    if (overlap * lower * share > tolerance) return 0;
    ends[0] -= share * overlap;
    ends[1] = ends[0];
    return 1;
}

// Corners of a convex polygon, anticlockwise.
struct Corners {
    double* at;  // (room, 2)
    int64_t count, room;

    CDPR_INLINE double x(int64_t k) const { return at[2 * k]; }
    CDPR_INLINE double y(int64_t k) const { return at[2 * k + 1]; }
    CDPR_INLINE void set(int64_t k, double x, double y) const {
        at[2 * k] = x;
        at[2 * k + 1] = y;
    }
    // A convex polygon never needs more space; round-off might.
    CDPR_INLINE void add(double x, double y) {
        if (count < room) set(count++, x, y);
    }
    CDPR_INLINE double distance(int64_t j, int64_t k) const { return hypotenuse(x(j) - x(k), y(j) - y(k)); }
    CDPR_INLINE double apart(int64_t k, double px, double py) const {
        return larger(absolute(px - x(k)), absolute(py - y(k)));
    }
};

// Write the part of a polygon with g . x <= b (Sutherland and Hodgman, Comm. ACM 17, 1974).
inline void cut(const Corners& old, double gx, double gy, double b, double tolerance, Corners& left) {
    left.count = 0;
    double px = old.x(old.count - 1), py = old.y(old.count - 1), before = gx * px + gy * py - b;
    for (int64_t k = 0; k < old.count; k++) {
        const double qx = old.x(k), qy = old.y(k), now = gx * qx + gy * qy - b;
        if ((before <= tolerance) != (now <= tolerance)) {
            const double share = smaller(larger(before / (before - now), 0.0), 1.0);
            left.add(px + share * (qx - px), py + share * (qy - py));
        }
        if (now <= tolerance) left.add(qx, qy);
        px = qx;
        py = qy;
        before = now;
    }
}

// Return whether a polygon has width: its area exceeds a tolerance times its circumference.
inline bool broad(const Corners& corners, double tolerance) {
    double area = 0.0, around = 0.0;
    for (int64_t k = 0; k < corners.count; k++) {
        const int64_t next = k + 1 == corners.count ? 0 : k + 1;
        const double ax = corners.x(k) - corners.x(0), ay = corners.y(k) - corners.y(0);
        const double bx = corners.x(next) - corners.x(0), by = corners.y(next) - corners.y(0);
        area += ax * by - ay * bx;
        around += hypotenuse(bx - ax, by - ay);
    }
    return area > tolerance * around;
}

// Keep the two corners with the largest distance.
inline void keep_ends(Corners& corners) {
    int64_t first = 0, second = 1;
    double longest = -1.0;
    for (int64_t j = 0; j < corners.count; j++)
        for (int64_t k = 0; k < j; k++) {
            const double distance = corners.distance(j, k);
            if (distance > longest) {
                first = k;
                second = j;
                longest = distance;
            }
        }
    const double x = corners.x(second), y = corners.y(second);
    corners.set(0, corners.x(first), corners.y(first));
    corners.set(1, x, y);
    corners.count = 2;
}

// Copy the corners without duplicates; for a polygon without width only its two ends. `tidied` may be the memory of
// `old`.
inline void tidy(const Corners& old, double tolerance, Corners& tidied) {
    tidied.count = 0;
    for (int64_t k = 0; k < old.count; k++) {
        const double x = old.x(k), y = old.y(k);
        if (tidied.count == 0 || tidied.apart(tidied.count - 1, x, y) > tolerance) tidied.add(x, y);
    }
    while (tidied.count > 1 && !(tidied.apart(0, tidied.x(tidied.count - 1), tidied.y(tidied.count - 1)) > tolerance))
        tidied.count--;
    if (tidied.count > 2 && !broad(tidied, tolerance)) keep_ends(tidied);
}

// Write the corners of the polygon into `corners`; none if it is empty, 1 for a point, 2 for a segment. `work` has the
// same size: 2 m + 4 corners. The limits cut a square around the polygon one after another.
inline void clip_polygon(const Polytope<double>& set, Corners& corners, double* work) {
    const double tolerance = clipping_tolerance(set);
    double reach = 0.0;  // |x_j| = |N_j . (t - c)| is at most this
    for (int64_t j = 0; j < 2; j++)
        reach = larger(reach, sum(0.0, 0, set.m, [&](int64_t i) {
                           return absolute(set.N(i, j)) *
                                  larger(absolute(set.low[i] - set.center[i]), absolute(set.high[i] - set.center[i]));
                       }));
    reach = 2.0 * reach + 1.0;  // no corner of the square remains
    Corners old = {corners.at, 0, corners.room}, left = {work, 0, corners.room};
    old.add(-reach, -reach);
    old.add(reach, -reach);
    old.add(reach, reach);
    old.add(-reach, reach);
    corners.count = 0;
    for (int64_t i = 0; i < set.m; i++) {
        const double gx = set.N(i, 0), gy = set.N(i, 1);
        if (gx == 0.0 && gy == 0.0) {
            if (!within(set, i, tolerance)) return;
            continue;
        }
        cut(old, -gx, -gy, set.center[i] - set.low[i], tolerance, left);
        if (left.count == 0) return;
        cut(left, gx, gy, set.high[i] - set.center[i], tolerance, old);
        if (old.count == 0) return;
    }
    tidy(old, tolerance, corners);
}

// Write the centroid of a convex polygon of at least one corner, of a segment or of a point into x (2), N: the mean of
// the triangles of a fan, weighted by area. It is never outside, however thin the polygon.
inline void centre_of_polygon(const Corners& corners, double* x) {
    const double ox = corners.x(0), oy = corners.y(0);
    double total = 0.0;
    x[0] = 0.0;
    x[1] = 0.0;
    for (int64_t k = 2; k < corners.count; k++) {
        const double ax = corners.x(k - 1) - ox, ay = corners.y(k - 1) - oy;
        const double bx = corners.x(k) - ox, by = corners.y(k) - oy;
        const double area = larger(ax * by - ay * bx, 0.0);  // negative values are round-off
        total += area;
        x[0] += area * (ax + bx) / 3.0;
        x[1] += area * (ay + by) / 3.0;
    }
    if (total > 0.0) {
        x[0] = ox + x[0] / total;
        x[1] = oy + x[1] / total;
        return;
    }
    for (int64_t k = 0; k < corners.count; k++) {
        x[0] += corners.x(k) / double(corners.count);
        x[1] += corners.y(k) / double(corners.count);
    }
}

}  // namespace cdpr::CDPR_TARGET
