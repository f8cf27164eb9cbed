// Directions, lengths and rates of the cables, and their wrench. SPDX-License-Identifier: Apache-2.0
//
// Conventions: `cdpr.model`; rows of `lines`: line.hpp. Rows with fewer than six numbers are BAD_INPUT.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/mechanics/side_by_side.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

// Return force and moment, N and N m, about p, world axes, of the tensions, N, on a body at p with attitude q. `eight`:
// result of `are_eight`.
template <bool eight = false, class T> CDPR_INLINE Wrench<T> pull_of_cables(const T* lines, int64_t width, int64_t m,
                                                                            const T* tension, Vector<T> p,
                                                                            Quaternion<T> q) {
    if constexpr (eight) return pull_of_eight(lines, tension, p, q);
    Wrench<T> sum = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int64_t i = 0; i < m; i++) sum = sum + pull_of_cable(line(lines, width, i, p, q), tension[i]);
    return sum;
}

// Wrench matrix, lengths and rates at a state of the platform.
template <class T> struct Geometry {
    const T* lines;  // (m, w), w >= 6
    const T* state;  // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    T* matrix;       // (6, m), moments about the platform's origin, m
    T* length;       // (m), m, from the anchor on the platform to the exit
    T* rate;         // (m), m/s, -W^T twist: motion along the pull shortens a cable
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), state(13), matrix(6, m), length(m), rate(m), m, w";
};

template <class T> inline int geometry(Geometry<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const Vector<T> p = vector(cables.state), v = vector(cables.state + 7), omega = vector(cables.state + 10);
    const Quaternion<T> q = quaternion(cables.state + 3);
    const int64_t m = cables.m;
    for (int64_t i = write_eights(cables.lines, cables.w, m, p, q, v, omega, cables.matrix, cables.length, cables.rate);
         i < m; i++) {
        const Column<T> column = column_of(line(cables.lines, cables.w, i, p, q), v, omega);
        store(column.direction, column.moment, cables.matrix + i, m);
        cables.length[i] = column.length;
        cables.rate[i] = column.rate;
    }
    return 0;
}

// Time derivative of the wrench matrix.
template <class T> struct MatrixRate {
    const T* lines;  // (m, w), w >= 6
    const T* state;  // (13), as of Geometry
    T* rate;         // (6, m), 1/s and m/s
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), state(13), rate(6, m), m, w";
};

template <class T> inline int matrix_rate(MatrixRate<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const Vector<T> p = vector(cables.state), v = vector(cables.state + 7), omega = vector(cables.state + 10);
    const Quaternion<T> q = quaternion(cables.state + 3);
    const int64_t m = cables.m;
    for (int64_t i = 0; i < m; i++) {
        const Line<T> cable = line(cables.lines, cables.w, i, p, q);
        const Vector<T> turning = cross(omega, cable.lever), l = cable.chord(cable.exit());
        const T norm = length(l);
        const Vector<T> u = l / norm;
        const Vector<T> stretching = cable.velocity_of_exit(v + turning) - v - turning;
        const Vector<T> du = (stretching - dot(u, stretching) * u) / norm;
        const Vector<T> moment = cross(turning, u) + cross(cable.lever, du);
        store(du, moment, cables.rate + i, m);
    }
    return 0;
}

// Force and moment of given tensions.
template <class T> struct CableWrench {
    const T* lines;    // (m, w), w >= 6
    const T* pose;     // (7): position, m, and quaternion
    const T* tension;  // (m), N
    T* wrench;         // (6), N and N m, about the platform's origin, world axes
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), pose(7), tension(m), wrench(6), m, w";
};

template <class T> inline int cable_wrench(CableWrench<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const Vector<T> p = vector(cables.pose);
    const Quaternion<T> q = quaternion(cables.pose + 3);
    store(pull_of_cables(cables.lines, cables.w, cables.m, cables.tension, p, q), cables.wrench);
    return 0;
}

// Exits of cables to given tips.
template <class T> struct Exits {
    const T* lines;     // (m, w), w >= 6
    const T* tip;       // (m, 3), anchors on the platform, m, world
    const T* velocity;  // (m, 3), of the tips, m/s
    T* point;           // (m, 3), exit points on the frame, m, world
    T* moving;          // (m, 3), velocity of these points, m/s
    T* wrapped_length;  // (m), length of cable on the exit, m
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), tip(m, 3), velocity(m, 3), point(m, 3), moving(m, 3), wrapped_length(m), m, w";
};

template <class T> inline int exits(Exits<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    for (int64_t i = 0; i < cables.m; i++) {
        const Vector<T> tip = vector(cables.tip + 3 * i), none = {0.0, 0.0, 0.0};
        const Line<T> cable = {cables.lines + i * cables.w, cables.w, none, none, tip};
        const ExitResult<T> exit = cable.lead();
        store(exit.point, cables.point + 3 * i);
        store(cable.velocity_of_exit(vector(cables.velocity + 3 * i)), cables.moving + 3 * i);
        cables.wrapped_length[i] = exit.wrapped_length;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
