// Distances of points and segments from convex solids. SPDX-License-Identifier: Apache-2.0
//
// A solid is a row of 11 numbers: its kind, the middle (3), m, its attitude (4), a quaternion, and its size (3), m:
// half widths of a box; radius of a sphere; radius and half height of a cylinder. The row of a convex hull is longer
// (hull.hpp).
#pragma once

#include <cdpr/mechanics/hull.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

// Bisections for the nearest point of a segment: to the last digit of its length.
constexpr int HALVINGS = 52;

// Distance of a point from a solid, m, negative inside; and its gradient, of length 1, in the solid's axes.
struct SignedDistance {
    double distance;
    Vector<double> gradient;
};

struct Solid {
    enum Kind { BOX, SPHERE, CYLINDER, HULL };
    static constexpr int KIND = 0, MIDDLE = 1, ATTITUDE = 4, SIZE = 8;

    const double* row;
    int64_t width;

    CDPR_INLINE bool is(Kind kind) const { return row[KIND] == kind; }
    CDPR_INLINE Vector<double> size() const { return vector(row + SIZE); }
    CDPR_INLINE Hull hull() const { return {row, width}; }

    // Return a point, m, in the axes of the solid, from its middle.
    CDPR_INLINE Vector<double> local(Vector<double> x) const {
        return rotate(conjugate(quaternion(row + ATTITUDE)), x - vector(row + MIDDLE));
    }
};

inline SignedDistance from_sphere(Vector<double> x, double radius) {
    const double size = length(x);
    if (size > 0.0) return {size - radius, x / size};
    return {size - radius, {1.0, 0.0, 0.0}};
}

inline SignedDistance from_cylinder(Vector<double> x, double radius, double half_height) {
    const double r = hypotenuse(x.x, x.y);
    const double across = r > 0.0 ? x.x / r : 1.0, away = r > 0.0 ? x.y / r : 0.0, up = copy_sign(1.0, x.z);
    const double p = r - radius, q = absolute(x.z) - half_height;
    if (p > 0.0 && q > 0.0) {
        const double size = hypotenuse(p, q);
        return {size, {across * p / size, away * p / size, up * q / size}};
    }
    if (p > q) return {p, {across, away, 0.0}};
    return {q, {0.0, 0.0, up}};
}

inline SignedDistance from_box(Vector<double> x, Vector<double> half) {
    const double p = absolute(x.x) - half.x, q = absolute(x.y) - half.y, s = absolute(x.z) - half.z;
    if (p <= 0.0 && q <= 0.0 && s <= 0.0) {
        if (p >= q && p >= s) return {p, {copy_sign(1.0, x.x), 0.0, 0.0}};
        if (q >= s) return {q, {0.0, copy_sign(1.0, x.y), 0.0}};
        return {s, {0.0, 0.0, copy_sign(1.0, x.z)}};
    }
    const double u = larger(p, 0.0), v = larger(q, 0.0), w = larger(s, 0.0);
    const double size = square_root(u * u + v * v + w * w);
    return {size, {copy_sign(u / size, x.x), copy_sign(v / size, x.y), copy_sign(w / size, x.z)}};
}

// Return the signed distance of a point in the axes of the solid, which is no hull. It is convex, like the solid.
inline SignedDistance signed_distance(Solid solid, Vector<double> x) {
    const Vector<double> size = solid.size();
    if (solid.is(Solid::SPHERE)) return from_sphere(x, size.x);
    if (solid.is(Solid::CYLINDER)) return from_cylinder(x, size.x, size.y);
    return from_box(x, size);
}

// Height of a point above the faces at +-half of one axis, if the anchor is on one of them; else `height`, NaN at
// first.
CDPR_INLINE double above_face(double anchor, double end, double half, double near, double height) {
    if (!(absolute(absolute(anchor) - half) <= near)) return height;
    const double up = copy_sign(end, anchor * end) - absolute(anchor);
    return height != height ? up : larger(height, up);
}

// Return the height of a cable's end above the faces of a solid with its anchor, both in the solid's axes, m.
//
// A cable from a point of the surface passes through the solid if and only if this is negative (its tangent cone
// there). NaN if the anchor is farther than `near` from all faces, or not near the surface.
inline double above(Solid solid, Vector<double> anchor, Vector<double> end, double near) {
    const Vector<double> size = solid.size();
    if (solid.is(Solid::SPHERE)) {
        const double r = length(anchor);
        return absolute(r - size.x) <= near ? dot(anchor, end) / r - r : NOT_A_NUMBER;
    }
    if (solid.is(Solid::CYLINDER)) {
        const double r = hypotenuse(anchor.x, anchor.y);
        const bool on_side = absolute(r - size.x) <= near;
        const double height = on_side ? (anchor.x * end.x + anchor.y * end.y) / r - r : NOT_A_NUMBER;
        return above_face(anchor.z, end.z, size.y, near, height);
    }
    double height = above_face(anchor.x, end.x, size.x, near, NOT_A_NUMBER);
    height = above_face(anchor.y, end.y, size.y, near, height);
    return above_face(anchor.z, end.z, size.z, near, height);
}

// Return the distance of a segment from a sphere around a solid, m: fast, and a lower bound of that from the solid.
CDPR_INLINE double beyond(Solid solid, Vector<double> start, Vector<double> end) {
    const Vector<double> size = solid.size();
    double radius = length(size);
    if (solid.is(Solid::HULL))
        radius = size.z;
    else if (solid.is(Solid::CYLINDER))
        radius = hypotenuse(size.x, size.y);
    return from_point(vector(solid.row + Solid::MIDDLE), start, end) - radius;
}

// Return the smallest signed distance along a segment, whose ends are in the world, m; convex, so by bisection.
inline double from_solid(Solid solid, Vector<double> start, Vector<double> end) {
    const Vector<double> a = solid.local(start), b = solid.local(end);
    if (solid.is(Solid::HULL)) return from_hull(solid.hull(), a, b);
    const Vector<double> d = b - a;
    const SignedDistance first = signed_distance(solid, a);
    if (dot(first.gradient, d) >= 0.0) return first.distance;
    const SignedDistance last = signed_distance(solid, b);
    if (dot(last.gradient, d) <= 0.0) return last.distance;
    double low = 0.0, high = 1.0, least = smaller(first.distance, last.distance);
    for (int k = 0; k < HALVINGS; k++) {
        const double s = 0.5 * (low + high);
        const SignedDistance here = signed_distance(solid, a + s * d);
        least = smaller(least, here.distance);
        if (dot(here.gradient, d) < 0.0)
            low = s;
        else
            high = s;
    }
    return least;
}

}  // namespace cdpr::CDPR_TARGET
