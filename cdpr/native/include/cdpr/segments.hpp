// Distances of points and segments from segments, m. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

// Square of the sine of an angle, below which the round-off of where two lines are nearest is felt.
constexpr double PARALLEL = 1e-6;

// Square of the distance of a point from a segment.
template <class T> CDPR_INLINE T square_from_point(Vector<T> x, Vector<T> start, Vector<T> end) {
    const Vector<T> d = end - start, r = x - start;
    const T square = dot(d, d), along = dot(r, d);
    const T inner = along / select(square > T(0.0), square, T(1.0));
    const T share = select(along <= T(0.0), T(0.0), select(along >= square, T(1.0), inner));
    const Vector<T> away = r - share * d;
    return dot(away, away);
}

// Distance of a point from a segment.
template <class T> CDPR_INLINE T from_point(Vector<T> x, Vector<T> start, Vector<T> end) {
    return square_root(square_from_point(x, start, end));
}

// Square of the least distance of an end of two segments from the other one.
template <class T> CDPR_INLINE T square_from_ends(Vector<T> start, Vector<T> end, Vector<T> first, Vector<T> last) {
    return smaller(smaller(square_from_point(start, first, last), square_from_point(end, first, last)),
                   smaller(square_from_point(first, start, end), square_from_point(last, start, end)));
}

// Distance between two segments: of where their lines are nearest, or from an end.
template <class T> CDPR_INLINE T between(Vector<T> start, Vector<T> end, Vector<T> first, Vector<T> last) {
    const Vector<T> d = end - start, e = last - first, r = start - first;
    const T dd = dot(d, d), ee = dot(e, e), de = dot(d, e), dr = dot(d, r), er = dot(e, r);
    const T square = dd * ee - de * de;
    const T by = select(square > T(0.0), square, T(1.0));  // of parallel segments the ends decide
    const T s = (de * er - ee * dr) / by, t = (dd * er - de * dr) / by;
    const Vector<T> away = r + s * d - t * e;
    const Truth<T> within = (square > T(0.0)) & (s > T(0.0)) & (s < T(1.0)) & (t > T(0.0)) & (t < T(1.0));
    const Truth<T> sure = within & (square > PARALLEL * dd * ee);
    T found = select(within, dot(away, away), T(INFINITE));
    if (!all(sure)) found = select(sure, found, smaller(found, square_from_ends(start, end, first, last)));
    return square_root(found);
}

}  // namespace CDPR_TARGET
}  // namespace cdpr
