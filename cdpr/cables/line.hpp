// One cable at a pose of the platform. SPDX-License-Identifier: Apache-2.0
//
// Conventions: `cdpr.model`. A row of `lines` holds the anchors A_i on the frame, world, and B_i on the platform,
// platform axes, m; if some exit is not a point, also the kind of its exit (parts.hpp) and that exit's numbers, `w` in
// all. Pott (2018), chapter 3: l_i = A_i - p - R B_i, u_i = l_i / |l_i|, W_i = [u_i; R B_i x u_i].
#pragma once

#include <cdpr/cables/parts.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/wrench.hpp>

namespace cdpr::CDPR_TARGET {

// Row of one cable, and the platform's pose.
template <class T> struct Line {
    static constexpr int FRAME = 0, PLATFORM = 3, EXIT = 6, NUMBERS = 7;

    const T* row;
    int64_t width;
    Vector<T> position;
    Vector<T> lever;  // R B_i
    Vector<T> tip;    // p + R B_i

    CDPR_INLINE int64_t count() const { return width - NUMBERS; }
    CDPR_INLINE bool rubs() const { return width > EXIT && cdpr::rubs(row[EXIT], count()); }
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
    CDPR_INLINE BentSpan<T> span(ExitResult<T> exit, const T* numbers, Vector<T> gravity) const {
        return {numbers, chord(exit.point), exit.wrapped_length, gravity, anchor() - exit.point};
    }
};

// Return whether each row has at least the anchors.
template <class T> CDPR_INLINE bool has_anchors(int64_t width) { return width >= Line<T>::EXIT; }

template <class T> CDPR_INLINE Line<T> line(const T* lines, int64_t width, int64_t i, Vector<T> p, Quaternion<T> q) {
    const T* row = lines + i * width;
    const Vector<T> lever = rotate(q, vector(row + Line<T>::PLATFORM));
    return {row, width, p, lever, p + lever};
}

// Return the tension at the winch per tension at the platform of a cable on an exit with friction, with this sine and
// cosine of its angle there, that moves towards the platform at `speed`, m/s.
template <class T> CDPR_INLINE T friction(const Line<T>& cable, T sine, T cosine, T speed) {
    return exit_friction(cable.row[Line<T>::EXIT], cable.row + Line<T>::NUMBERS, sine, cosine, speed);
}

// Return force and moment about the platform's position, N and N m, world axes, of a tension, N.
template <class T> CDPR_INLINE Wrench<T> pull_of_cable(const Line<T>& cable, T tension) {
    const Vector<T> l = cable.chord(cable.exit());
    const Vector<T> f = (tension / length(l)) * l;
    return {f, cross(cable.lever, f)};
}

// Column of the wrench matrix, moment in m, with the cable's length, m, and its rate, m/s.
template <class T> struct Column {
    Vector<T> direction, moment;
    T length, rate;
};

// Return the column for a platform with velocity v, m/s, and angular velocity omega, rad/s, world axes.
template <class T> CDPR_INLINE Column<T> column_of(const Line<T>& cable, Vector<T> v, Vector<T> omega) {
    const ExitResult<T> exit = cable.lead();
    const Vector<T> l = cable.chord(exit.point);
    const T norm = length(l);
    const Vector<T> u = l / norm, moment = cross(cable.lever, u);
    return {u, moment, norm + exit.wrapped_length, -dot(u, v) - dot(moment, omega)};
}

// Write a column of a matrix (6, m).
template <class T> CDPR_INLINE void store(Vector<T> direction, Vector<T> moment, T* column, int64_t m) {
    column[0] = direction.x;
    column[m] = direction.y;
    column[2 * m] = direction.z;
    column[3 * m] = moment.x;
    column[4 * m] = moment.y;
    column[5 * m] = moment.z;
}

}  // namespace cdpr::CDPR_TARGET
