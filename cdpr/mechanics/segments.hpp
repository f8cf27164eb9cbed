// Distances of points and segments from segments, m. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

// Square of the sine of an angle, below which round-off affects the nearest points of two lines.
constexpr double PARALLEL = 1e-6;

// Share of a segment at its point nearest to another point. `along` is the product of the segment with the vector from
// its start to that point, `square` the product of the segment with itself.
template <class T> CDPR_INLINE T nearest_share(T along, T square) {
    const T inner = along / select(square > T(0.0), square, T(1.0));
    return select(along <= T(0.0), T(0.0), select(along >= square, T(1.0), inner));
}

template <class T> CDPR_INLINE T square(Vector<T> v) { return dot(v, v); }

// Distance of a point from a segment.
template <class T> CDPR_INLINE T from_point(Vector<T> x, Vector<T> start, Vector<T> end) {
    const Vector<T> d = end - start, r = x - start;
    return square_root(square(r - nearest_share(dot(r, d), dot(d, d)) * d));
}

// Distance between two segments: between the nearest points of their lines, or of an end from the other segment.
template <class T> CDPR_INLINE T between(Vector<T> start, Vector<T> end, Vector<T> first, Vector<T> last) {
    const Vector<T> d = end - start, e = last - first, r = start - first;
    const T dd = dot(d, d), ee = dot(e, e), de = dot(d, e), dr = dot(d, r), er = dot(e, r);
    const T sines = dd * ee - de * de;
    const T by = select(sines > T(0.0), sines, T(1.0));  // the ends decide for parallel segments
    const T s = (de * er - ee * dr) / by, t = (dd * er - de * dr) / by;
    const Truth<T> within = (sines > T(0.0)) & (s > T(0.0)) & (s < T(1.0)) & (t > T(0.0)) & (t < T(1.0));
    const Truth<T> sure = within & (sines > PARALLEL * dd * ee);
    T found = select(within, square(r + s * d - t * e), T(INFINITE));
    if (!all(sure)) {
        const Vector<T> ahead = end - first, behind = last - start;
        const T starts =
            smaller(square(r - nearest_share(er, ee) * e), square(ahead - nearest_share(dot(ahead, e), ee) * e));
        const T ends =
            smaller(square(r + nearest_share(-dr, dd) * d), square(behind - nearest_share(dot(behind, d), dd) * d));
        found = select(sure, found, smaller(found, smaller(starts, ends)));
    }
    return square_root(found);
}

}  // namespace cdpr::CDPR_TARGET
