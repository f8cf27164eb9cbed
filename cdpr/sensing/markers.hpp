// Markers in the image of a pinhole camera. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/sensing/rays.hpp>

namespace cdpr::CDPR_TARGET {

// m: a marker on a surface, seen from outside, is not hidden by this surface; files have rounded coordinates.
constexpr double MARKER_DEPTH = 1e-4;

// Rotation and translation from the axes of a body to those of the world.
template <class T> struct PlacementOf {
    Vector<T> place;
    Quaternion<T> attitude;

    CDPR_INLINE Vector<T> outwards(Vector<T> x) const { return place + rotate(attitude, x); }
    CDPR_INLINE Vector<T> inwards(Vector<T> x) const { return rotate(conjugate(attitude), x - place); }
};
using Placement = PlacementOf<double>;

struct Markers {
    const double* state;    // (13), of the platform
    const double* camera;   // (7), pose of the camera in the axes of its body: z forwards, x to the right of the image
    const double* markers;  // (k, 3), m, in the axes of the other body
    const double* lens;     // (6), px: focal lengths (2), principal point (2), width and height of the image
    const double* solids;   // (s, w), obstacles of the world
    const double* shape;    // (c, d), solids of the platform, in its axes
    double* pixels;         // (k, 2), px, kept while a marker is not seen
    double* seen;           // (k), 1 if a marker is seen, else 0
    int64_t carried;        // 1 if the camera is on the platform and the markers in the world; 0 for the opposite
    int64_t k;
    int64_t s;
    int64_t w;
    int64_t c;
    int64_t d;
    static constexpr char fields[] =
        "state(13), camera(7), markers(k, 3), lens(6), solids(s, w), shape(c, d), both pixels(k, 2), seen(k), carried, "
        "k, s, w >= 11, c, d >= 11";
};

CDPR_INLINE bool hides(Solid solid, Vector<double> from, Vector<double> direction, double distance) {
    return along_ray(solid, from, direction) < distance - MARKER_DEPTH;
}

// Write the pixels of the markers that are in the image and not hidden. At time 0 all others are in the middle.
inline int project_markers(Markers& p, double time) {
    const Placement platform = {vector(p.state), quaternion(p.state + 3)};
    const Placement mount = {vector(p.camera), quaternion(p.camera + 3)};
    const Vector<double> eye = p.carried ? platform.outwards(mount.place) : mount.place;
    for (int64_t i = 0; i < p.k; i++) {
        double* const pixel = p.pixels + 2 * i;
        if (!(time > 0.0)) pixel[0] = p.lens[2], pixel[1] = p.lens[3];
        const Vector<double> marker = vector(p.markers + 3 * i);
        const Vector<double> place = p.carried ? marker : platform.outwards(marker);
        const Vector<double> x = mount.inwards(p.carried ? platform.inwards(place) : place);
        const double u = p.lens[0] * x.x / x.z + p.lens[2], v = p.lens[1] * x.y / x.z + p.lens[3];
        const double distance = length(place - eye);
        const Vector<double> direction = (place - eye) / distance;
        bool seen = x.z > 0.0 && u >= 0.0 && u < p.lens[4] && v >= 0.0 && v < p.lens[5];
        for (int64_t j = 0; seen && j < p.s; j++) seen = !hides({p.solids + p.w * j, p.w}, eye, direction, distance);
        const Vector<double> own = platform.inwards(eye);
        const Vector<double> ahead = rotate(conjugate(platform.attitude), direction);
        for (int64_t j = 0; seen && j < p.c; j++) {
            const Solid solid = {p.shape + p.d * j, p.d};
            const bool inside = p.carried && along_ray(solid, own, ahead) == 0.0;  // the camera is built into it
            seen = inside || !hides(solid, own, ahead, distance);
        }
        p.seen[i] = seen ? 1.0 : 0.0;
        if (seen) pixel[0] = u, pixel[1] = v;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
