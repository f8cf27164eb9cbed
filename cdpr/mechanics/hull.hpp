// Distance of a segment from a convex hull. SPDX-License-Identifier: Apache-2.0
//
// The row of a hull (solids.hpp): its size is the numbers of its triangles and edges, and the radius, m, of a sphere
// around it. Then follow for each triangle its normal (3), height and corners (9), and for each edge both ends (6),
// relative to the middle, m.
#pragma once

#include <cdpr/mechanics/segments.hpp>

namespace cdpr::CDPR_TARGET {

// Height of a face over a segment a + s d: low + s up.
struct Slope {
    double value, low, up;  // at s, at 0, and over s
};

struct Hull {
    static constexpr int FACES = 8, EDGES = 9, NUMBERS = 11, FACE = 13, EDGE = 6, HEIGHT = 3, CORNERS = 4;

    const double* row;
    int64_t width;

    CDPR_INLINE bool whole() const {
        return row[FACES] >= 0.0 && row[EDGES] >= 0.0 &&
               NUMBERS + FACE * row[FACES] + EDGE * row[EDGES] <= double(width);
    }
    CDPR_INLINE int64_t faces() const { return static_cast<int64_t>(row[FACES]); }
    CDPR_INLINE int64_t edges() const { return static_cast<int64_t>(row[EDGES]); }
    CDPR_INLINE const double* face(int64_t k) const { return row + NUMBERS + FACE * k; }
    CDPR_INLINE const double* edge(int64_t k) const { return row + NUMBERS + FACE * faces() + EDGE * k; }
};

// Return the height of a + s d over the face with the largest height.
inline Slope highest(Hull hull, Vector<double> a, Vector<double> d, double s) {
    Slope found = {-INFINITE, 0.0, 0.0};
    for (int64_t k = 0; k < hull.faces(); k++) {
        const double* face = hull.face(k);
        const double low = dot(vector(face), a) - face[Hull::HEIGHT], up = dot(vector(face), d), value = low + s * up;
        if (value > found.value) found = {value, low, up};
    }
    return found;
}

// Return the smallest of that height for s from 0 to 1, if it is negative; else a non-negative number.
//
// It is the maximum of one straight line per face. Its minimum is the intersection of the largest lines on either side,
// unless another line is above them there, which then replaces one.
inline double lowest(Hull hull, Vector<double> a, Vector<double> d) {
    Slope first = highest(hull, a, d, 0.0);
    if (first.up >= 0.0) return first.value;
    Slope last = highest(hull, a, d, 1.0);
    if (last.up <= 0.0) return last.value;
    double value = last.value;
    for (int64_t k = 0; k < hull.faces(); k++) {
        const double s = smaller(larger((last.low - first.low) / (first.up - last.up), 0.0), 1.0);
        const double meeting = first.low + s * first.up;
        if (meeting > 0.0) return meeting;
        const Slope here = highest(hull, a, d, s);
        value = here.value;
        if (here.up == 0.0 || (here.low == first.low && here.up == first.up) ||
            (here.low == last.low && here.up == last.up))
            break;
        if (here.up < 0.0)
            first = here;
        else
            last = here;
    }
    return value;
}

// Return whether a point is over, or under, a triangle with normal n; not over its edges. corners: (3, 3).
inline bool over(const double* corners, Vector<double> n, Vector<double> x) {
    for (int k = 0; k < 3; k++) {
        const Vector<double> p = vector(corners + 3 * k), q = vector(corners + 3 * ((k + 1) % 3));
        if (dot(cross(q - p, x - p), n) <= 0.0) return false;
    }
    return true;
}

// Return the distance of a segment, in the hull's axes, from the hull, m; negative if it passes through, as for other
// solids; NaN if the row is too short for its numbers.
//
// Without contact, it is the distance from an edge, or that of an end from a face below it.
inline double from_hull(Hull hull, Vector<double> a, Vector<double> b) {
    if (!hull.whole()) return NOT_A_NUMBER;
    const double depth = lowest(hull, a, b - a);
    if (depth < 0.0) return depth;
    double least = INFINITE;
    const Vector<double> ends[] = {a, b};
    for (int64_t k = 0; k < hull.faces(); k++) {
        const double* face = hull.face(k);
        const Vector<double> n = vector(face);
        for (const Vector<double>& x : ends) {
            const double height = dot(n, x) - face[Hull::HEIGHT];
            if (0.0 <= height && height < least && over(face + Hull::CORNERS, n, x)) least = height;
        }
    }
    for (int64_t k = 0; k < hull.edges(); k++) {
        const double* edge = hull.edge(k);
        least = smaller(least, between(a, b, vector(edge), vector(edge + 3)));
    }
    return least;
}

}  // namespace cdpr::CDPR_TARGET
