// Classical Runge-Kutta of order four, for the variables of any integrator. SPDX-License-Identifier: Apache-2.0
//
// A step of h has four stages. Each takes the slope k at its point y and adds weight * k to a sum; the next point is
// y_0 + reach * k, and the result of the step y_0 + h/6 * sum.
#pragma once

#include <cdpr/mechanics/attitude.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int STAGES = 4;

// Weight of a stage in the sum of the slopes.
CDPR_INLINE double weight(int stage) { return stage == 0 || stage == 3 ? 1.0 : 2.0; }

// Distance of the next stage's point from the start of the step, s; unused after the last.
CDPR_INLINE double reach(int stage, double h) { return stage == 2 ? h : 0.5 * h; }

// a + c b.
template <class T> CDPR_INLINE Vector<T> along(Vector<T> a, T c, Vector<T> b) { return a + c * b; }
template <class T> CDPR_INLINE Quaternion<T> along(Quaternion<T> a, T c, Quaternion<T> b) {
    return {a.w + c * b.w, a.x + c * b.x, a.y + c * b.y, a.z + c * b.z};
}

// Return the point after a step of h, s, from `start`. `none` is zero; `slope(point, since)` is the rate of a point at
// a time, s, after the start; `along` is defined for points.
template <class T, class Point, class Slope>
CDPR_INLINE Point runge_kutta(Point start, Point none, double h, Slope slope) {
    Point point = start, sum = none;
    double since = 0.0;
    for (int stage = 0; stage < STAGES; stage++) {
        const Point k = slope(point, since);
        since = reach(stage, h);
        sum = along(sum, T(weight(stage)), k);
        point = along(start, T(since), k);
    }
    return along(start, T(h / 6.0), sum);
}

}  // namespace cdpr::CDPR_TARGET
