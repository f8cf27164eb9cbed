// Points of a polytope { x : low <= c + N x <= high }. SPDX-License-Identifier: Apache-2.0
//
// Of a tension distribution, N (m, r) and c are the null-space form, and points are tensions.
#pragma once

#include <cdpr/matrix.hpp>
#include <cdpr/sum.hpp>
#include <cdpr/tension/tension_problem.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Polytope {
    Matrix<const T> N;  // (m, r), with zeros for rows that are round-off
    const T* center;    // (m), c
    const T* low;       // (m), may be infinite
    const T* high;      // (m)
    T* x;               // (r), result
    T* point;           // (m), c + N x, exactly on the active limits and never outside
    T* active;          // (m): -1, 0 or 1 if the lower, no or the upper limit is active
    int64_t r, m;
};

// The polytope of a problem in null-space form; its points are the tensions.
template <class T> CDPR_INLINE Polytope<T> polytope_of(const TensionProblem<T>& problem, int64_t r, T* x, T* active) {
    const Matrix<const T> N = {problem.basis, problem.m};
    return {N, problem.center(), problem.low(), problem.high(), x, problem.tension, active, r, problem.m};
}

// Largest distance by which a point was moved onto the limits, and the largest number among c and the limits.
template <class T> struct Excess {
    T most, scale;
};

// Write c, moved onto violated limits, as the point, and 0 into `active`.
template <class T> CDPR_INLINE Excess<T> least(const Polytope<T>& p) {
    Excess<T> found = {0.0, 0.0};
    for (int64_t i = 0; i < p.m; i++) {
        const T c = p.center[i], low = p.low[i], high = p.high[i];
        p.active[i] = 0.0;
        found.scale = larger(found.scale, absolute(c));
        found.scale = select(low > T(-INFINITE), larger(found.scale, absolute(low)), found.scale);
        found.most = larger(larger(found.most, low - c), c - high);
        p.point[i] = smaller(larger(c, low), high);
    }
    return found;
}

// Return entry i of c + N x.
template <class T> CDPR_INLINE T coordinate(const Polytope<T>& p, int64_t i) {
    return sum(p.center[i], 0, p.r, [&](int64_t j) { return p.N(i, j) * p.x[j]; });
}

// Write the point of x, exactly on the active limits and never outside.
CDPR_INLINE void settle(const Polytope<double>& p) {
    for (int64_t i = 0; i < p.m; i++) {
        double s = coordinate(p, i);
        if (p.active[i] < 0.0)
            s = p.low[i];
        else if (p.active[i] > 0.0)
            s = p.high[i];
        p.point[i] = smaller(larger(s, p.low[i]), p.high[i]);
    }
}

}  // namespace cdpr::CDPR_TARGET
