// Cables of one robot side by side: eight in the lanes of a register. SPDX-License-Identifier: Apache-2.0
//
// Each lane performs the operations of its cable alone, and sums keep the order of the cables: the bits are those of
// one cable after the other. Only for exits that are points, or all of one kind with friction. Lanes are already eight
// robots: these functions do nothing for them.
#pragma once

#include <cdpr/cables/line.hpp>
#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

// Return whether there are eight cables with points as exits.
template <class T> CDPR_INLINE bool are_eight(int64_t, int64_t) { return false; }

// Return force and moment of the tensions, N, of such cables on a body at p with attitude q.
template <class T> CDPR_INLINE Wrench<T> pull_of_eight(const T*, const T*, Vector<T>, Quaternion<T>) { return {}; }

// Write columns of the wrench matrix (6, m), lengths and rates (m) of full groups of such cables at a pose of a
// platform with velocities v, m/s, and omega, rad/s; return the number of these cables.
template <class T> CDPR_INLINE int64_t write_eights(const T*, int64_t, int64_t, Vector<T>, Quaternion<T>, Vector<T>,
                                                    Vector<T>, T*, T*, T*) {
    return 0;
}

// Return whether there are eight cables on exits of one kind with friction.
template <class T> CDPR_INLINE bool are_eight_rubbing(const T*, int64_t, int64_t) { return false; }

#ifdef CDPR_LANES

// Rows of eight cables, as one.
template <int COUNT = Line<Lanes>::EXIT> struct EightLines {
    Lanes row[COUNT];

    CDPR_INLINE EightLines(const double* lines) {
        for (int j = 0; j < COUNT; j++) row[j] = gather(lines + j, COUNT);
    }

    CDPR_INLINE Line<Lanes> at(Vector<double> p, Quaternion<double> q) const {
        return line<Lanes>(row, COUNT, 0, same(p), {q.w, q.x, q.y, q.z});
    }

    // The same vector in all lanes.
    static CDPR_INLINE Vector<Lanes> same(Vector<double> v) { return {v.x, v.y, v.z}; }
};

// Rows of eight cables on exits with friction.
using EightRubbing = EightLines<Line<Lanes>::NUMBERS + MOST_OF_EXIT>;

// Number of cables in full groups.
CDPR_INLINE int64_t in_groups(int64_t width, int64_t m) { return width == Line<double>::EXIT ? m - m % WIDTH : 0; }

template <> CDPR_INLINE bool are_eight<double>(int64_t width, int64_t m) {
    return width == Line<double>::EXIT && m == WIDTH;
}

template <> CDPR_INLINE bool are_eight_rubbing<double>(const double* lines, int64_t width, int64_t m) {
    if (width != Line<double>::NUMBERS + MOST_OF_EXIT || m != WIDTH) return false;
    for (int i = 1; i < WIDTH; i++)
        if (lines[i * width + Line<double>::EXIT] != lines[Line<double>::EXIT]) return false;
    return rubs(lines[Line<double>::EXIT], width - Line<double>::NUMBERS);
}

CDPR_INLINE void add_each(Vector<Lanes> terms, Vector<double>& sum) {
    for (int i = 0; i < WIDTH; i++) sum = sum + Vector<double>{terms.x.get(i), terms.y.get(i), terms.z.get(i)};
}

CDPR_INLINE Wrench<double> pull_of_eight(const double* lines, const double* tension, Vector<double> p,
                                         Quaternion<double> q) {
    Wrench<double> sum = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    const Wrench<Lanes> pull = pull_of_cable(EightLines<>(lines).at(p, q), gather(tension, 1));
    add_each(pull.force, sum.force);
    add_each(pull.moment, sum.moment);
    return sum;
}

CDPR_INLINE int64_t write_eights(const double* lines, int64_t width, int64_t m, Vector<double> p, Quaternion<double> q,
                                 Vector<double> v, Vector<double> omega, double* matrix, double* length, double* rate) {
    const int64_t count = in_groups(width, m);
    for (int64_t i = 0; i < count; i += WIDTH) {
        const Column<Lanes> column =
            column_of(EightLines<>(lines + i * width).at(p, q), EightLines<>::same(v), EightLines<>::same(omega));
        const Vector<Lanes> u = column.direction, moment = column.moment;
        const Lanes rows[] = {u.x, u.y, u.z, moment.x, moment.y, moment.z};
        for (int j = 0; j < 6; j++) scatter(rows[j], matrix + j * m + i);
        scatter(column.length, length + i);
        scatter(column.rate, rate + i);
    }
    return count;
}

#endif

}  // namespace cdpr::CDPR_TARGET
