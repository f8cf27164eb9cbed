// Directions, lengths and rates of the cables, and what they exert. SPDX-License-Identifier: Apache-2.0
//
// Conventions: `cdpr.model`. A row of `lines` holds the anchors A_i on the frame, world, and B_i on the platform,
// platform axes, m; where some cable leaves from something else than a point, also the kind of its exit (parts.hpp) and
// that exit's numbers, `w` in all; rows of less than six are BAD_INPUT. Pott (2018), chapter 3: l_i = A_i - p - R B_i,
// u_i = l_i / |l_i|, W_i = [u_i; R B_i x u_i].
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/parts.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/status.hpp>
#include <cdpr/wrench.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

// The row of one cable, and the platform's pose.
template <class T> struct Line {
    static constexpr int FRAME = 0, PLATFORM = 3, EXIT = 6, NUMBERS = 7;

    const T* row;
    int64_t width;
    Vector<T> position;
    Vector<T> lever;  // R B_i
    Vector<T> tip;    // p + R B_i

    CDPR_INLINE int64_t count() const { return width - NUMBERS; }
    CDPR_INLINE bool leaves_a_point() const { return width <= EXIT || is(row[EXIT], POINT); }
    CDPR_INLINE Vector<T> anchor() const { return vector(row + FRAME); }

    CDPR_INLINE Vector<T> exit() const {
        return leaves_a_point() ? anchor() : exit_point(row[EXIT], anchor(), row + NUMBERS, count(), tip);
    }
    CDPR_INLINE ExitResult<T> lead() const {
        if (leaves_a_point()) return {anchor(), 0.0};
        return cdpr::lead(row[EXIT], anchor(), row + NUMBERS, count(), tip);
    }
    CDPR_INLINE Vector<T> velocity_of_exit(Vector<T> V) const {
        if (leaves_a_point()) return {0.0, 0.0, 0.0};
        return exit_velocity(row[EXIT], anchor(), row + NUMBERS, count(), tip, V);
    }
    CDPR_INLINE Vector<T> chord(Vector<T> point) const { return point - position - lever; }
};

// Return whether each row has the anchors at least.
template <class T> CDPR_INLINE bool has_anchors(int64_t width) { return width >= Line<T>::EXIT; }

template <class T> CDPR_INLINE Line<T> line(const T* lines, int64_t width, int64_t i, Vector<T> p, Quaternion<T> q) {
    const T* row = lines + i * width;
    const Vector<T> lever = rotate(q, vector(row + Line<T>::PLATFORM));
    return {row, width, p, lever, p + lever};
}

// Return force and moment, N and N m, about p, world axes, of the tensions, N, on a body at p with attitude q.
template <class T> CDPR_INLINE Wrench<T> pull_of_cables(const T* lines, int64_t width, int64_t m, const T* tension,
                                                        Vector<T> p, Quaternion<T> q) {
    Wrench<T> sum = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int64_t i = 0; i < m; i++) {
        const Line<T> cable = line(lines, width, i, p, q);
        const Vector<T> l = cable.chord(cable.exit());
        const Vector<T> f = (tension[i] / length(l)) * l;
        sum = sum + Wrench<T>{f, cross(cable.lever, f)};
    }
    return sum;
}

// Wrench matrix, lengths and rates at a state of the platform.
template <class T> struct Geometry {
    const T* lines;  // (m, w), w >= 6
    const T* state;  // (13): position, m; quaternion; velocity, m/s; angular velocity, rad/s; world axes
    T* matrix;       // (6, m), moments about the platform's origin, m
    T* length;       // (m), m, from the anchor on the platform to where the exit begins
    T* rate;         // (m), m/s, -W^T twist: a cable shortens where it pulls along the motion
    int64_t m;
    int64_t w;
    static constexpr Field fields[] = {in<T>("lines", "m", "w >= 6"),
                                       in<T>("state", "13"),
                                       out<T>("matrix", "6", "m"),
                                       out<T>("length", "m"),
                                       out<T>("rate", "m"),
                                       size("m"),
                                       size("w")};
};

template <class T> inline int geometry(Geometry<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const Vector<T> p = vector(cables.state), v = vector(cables.state + 7), omega = vector(cables.state + 10);
    const Quaternion<T> q = quaternion(cables.state + 3);
    const int64_t m = cables.m;
    for (int64_t i = 0; i < m; i++) {
        const Line<T> cable = line(cables.lines, cables.w, i, p, q);
        const ExitResult<T> exit = cable.lead();
        const Vector<T> l = cable.chord(exit.point);
        const T norm = length(l);
        const Vector<T> u = l / norm, moment = cross(cable.lever, u);
        T* column = cables.matrix + i;
        column[0] = u.x;
        column[m] = u.y;
        column[2 * m] = u.z;
        column[3 * m] = moment.x;
        column[4 * m] = moment.y;
        column[5 * m] = moment.z;
        cables.length[i] = norm + exit.wrapped_length;
        cables.rate[i] = -dot(u, v) - dot(moment, omega);
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
    static constexpr Field fields[] = {in<T>("lines", "m", "w >= 6"), in<T>("state", "13"), out<T>("rate", "6", "m"),
                                       size("m"), size("w")};
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
        T* column = cables.rate + i;
        column[0] = du.x;
        column[m] = du.y;
        column[2 * m] = du.z;
        column[3 * m] = moment.x;
        column[4 * m] = moment.y;
        column[5 * m] = moment.z;
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
    static constexpr Field fields[] = {in<T>("lines", "m", "w >= 6"), in<T>("pose", "7"), in<T>("tension", "m"),
                                       out<T>("wrench", "6"),         size("m"),          size("w")};
};

template <class T> inline int cable_wrench(CableWrench<T>& cables) {
    if (!has_anchors<T>(cables.w)) return code(T(double(BAD_INPUT)));
    const Vector<T> p = vector(cables.pose);
    const Quaternion<T> q = quaternion(cables.pose + 3);
    store(pull_of_cables(cables.lines, cables.w, cables.m, cables.tension, p, q), cables.wrench);
    return 0;
}

// Exits of cables that lead to given tips.
template <class T> struct Exits {
    const T* lines;     // (m, w), w >= 6
    const T* tip;       // (m, 3), anchors on the platform, m, world
    const T* velocity;  // (m, 3), of the tips, m/s
    T* point;           // (m, 3), where the cables leave the frame, m, world
    T* moving;          // (m, 3), velocity of these points, m/s
    T* wrapped_length;  // (m), length of cable that lies on the exit, m
    int64_t m;
    int64_t w;
    static constexpr Field fields[] = {in<T>("lines", "m", "w >= 6"),
                                       in<T>("tip", "m", "3"),
                                       in<T>("velocity", "m", "3"),
                                       out<T>("point", "m", "3"),
                                       out<T>("moving", "m", "3"),
                                       out<T>("wrapped_length", "m"),
                                       size("m"),
                                       size("w")};
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

}  // namespace CDPR_TARGET
}  // namespace cdpr
