// Operations on admissible intervals and polygons. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/status.hpp>
#include <cdpr/tension/polygon.hpp>

namespace cdpr::CDPR_TARGET {

// Corners of { x : low <= c + N x <= high }, N (m, dimension).
template <int dimension> struct AdmissibleCorners {
    const double* basis;  // (m, dimension), N
    const double* box;    // (3, m), N: c and the limits
    double* corners;      // (2 m + 4, dimension), N; the first ones are written
    double* count;        // (1), of the corners
    double* space;        // (2 m + 4, dimension), work space
    int64_t m;
    static constexpr char columns[] = {'0' + dimension, 0};
    static constexpr auto fields = join("basis(m, ", columns, "), box(3, m), corners(2*m + 4, ", columns,
                                        "), count(1), work space(2*m + 4, ", columns, "), m");

    CDPR_INLINE Polytope<double> set() const {
        return {{basis, dimension}, box, box + m, box + 2 * m, nullptr, nullptr, nullptr, dimension, m};
    }
};

// Write the ends of the interval; return OK, or INFEASIBLE if it is empty.
inline int admissible_interval(AdmissibleCorners<1>& problem) {
    const int64_t count = clip_interval(problem.set(), problem.corners);
    *problem.count = double(count);
    return count > 0 ? OK : INFEASIBLE;
}

// Write the corners of the polygon; return OK, or INFEASIBLE if it is empty.
inline int admissible_polygon(AdmissibleCorners<2>& problem) {
    Corners corners = {problem.corners, 0, 2 * problem.m + 4};
    clip_polygon(problem.set(), corners, problem.space);
    *problem.count = double(corners.count);
    return corners.count > 0 ? OK : INFEASIBLE;
}

}  // namespace cdpr::CDPR_TARGET
