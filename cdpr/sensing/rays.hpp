// Distances along rays to convex solids. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/mechanics/solids.hpp>

namespace cdpr::CDPR_TARGET {

// Part of a ray within a solid, by distance from its start, m; empty if `in` exceeds `out`.
struct Inside {
    double in, out;

    // Keep the part where height + s slope is at most 0.
    CDPR_INLINE void clip(double height, double slope) {
        if (slope < 0.0)
            in = larger(in, -height / slope);
        else if (slope > 0.0)
            out = smaller(out, -height / slope);
        else if (height > 0.0)
            out = -INFINITE;
    }

    CDPR_INLINE void clip_between(double x, double d, double half) {
        clip(x - half, d);
        clip(-x - half, -d);
    }

    // Keep the part within a distance from the origin of a sphere, or from the axis of a cylinder; d is not normalised.
    inline void clip_round(Vector<double> x, Vector<double> d, double radius) {
        const double square = dot(d, d);
        const double nearest = square > 0.0 ? -dot(x, d) / square : 0.0;
        const Vector<double> foot = x + nearest * d;
        const double free = radius * radius - dot(foot, foot);
        if (free < 0.0) {
            out = -INFINITE;
        } else if (square > 0.0) {
            const double half = square_root(free / square);
            in = larger(in, nearest - half);
            out = smaller(out, nearest + half);
        }
    }
};

// Distance from the start x of a ray with the unit direction d to a solid, m; 0 inside, infinite without a hit.
inline double along_ray(Solid solid, Vector<double> x, Vector<double> d) {
    const Vector<double> a = solid.local(x), b = rotate(conjugate(quaternion(solid.row + Solid::ATTITUDE)), d);
    const Vector<double> size = solid.size();
    Inside part = {0.0, INFINITE};
    if (solid.is(Solid::SPHERE)) {
        part.clip_round(a, b, size.x);
    } else if (solid.is(Solid::CYLINDER)) {
        part.clip_round({a.x, a.y, 0.0}, {b.x, b.y, 0.0}, size.x);
        part.clip_between(a.z, b.z, size.y);
    } else if (solid.is(Solid::BOX)) {
        part.clip_between(a.x, b.x, size.x);
        part.clip_between(a.y, b.y, size.y);
        part.clip_between(a.z, b.z, size.z);
    } else {
        const Hull hull = solid.hull();
        if (!hull.whole()) return INFINITE;
        for (int64_t k = 0; k < hull.faces(); k++) {
            const double* const face = hull.face(k);
            part.clip(dot(vector(face), a) - face[Hull::HEIGHT], dot(vector(face), b));
        }
    }
    return part.in <= part.out ? part.in : INFINITE;
}

struct Rays {
    const double* state;       // (13), of the platform
    const double* point;       // (3), m, start of the rays, platform axes
    const double* directions;  // (k, 3), of length 1, platform axes
    const double* solids;      // (s, w), rows as in solids.hpp
    double* distances;         // (k), m
    double reach;              // m, distance without a hit
    int64_t k;
    int64_t s;
    int64_t w;
    static constexpr char fields[] =
        "state(13), point(3), directions(k, 3), solids(s, w), distances(k), reach, k, s, w >= 11";
};

// Write the distance to the nearest solid along each ray.
inline int cast_rays(Rays& p) {
    const Quaternion<double> attitude = quaternion(p.state + 3);
    const Vector<double> start = vector(p.state) + rotate(attitude, vector(p.point));
    for (int64_t i = 0; i < p.k; i++) {
        const Vector<double> d = rotate(attitude, vector(p.directions + 3 * i));
        double nearest = p.reach;
        for (int64_t j = 0; j < p.s; j++) {
            const Solid solid = {p.solids + p.w * j, p.w};
            nearest = smaller(nearest, along_ray(solid, start, d));
        }
        p.distances[i] = nearest;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
