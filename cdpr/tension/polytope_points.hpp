// Nearest and extreme point of a polytope, as operations. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/tension/extreme_point.hpp>

namespace cdpr::CDPR_TARGET {

struct NearestPoint {
    const double* basis;  // (m, r), N, with zeros for rows that are round-off
    const double* box;    // (3, m), c and the limits, which may be infinite
    double* x;            // (r)
    double* point;        // (m), c + N x
    double* active;       // (m): -1, 0 or 1 if the lower, no or the upper limit is active
    double* steps;        // (1), number of steps; minus a status on failure
    double* search;       // (2 r + 8, m + r), work space
    int64_t m;
    int64_t r;
    static constexpr char fields[] =
        "basis(m, r), box(3, m), x(r), point(m), active(m), steps(1), work search(2*r + 8, m + r), m, r";

    CDPR_INLINE Polytope<double> polytope() const {
        return {{basis, r}, box, box + m, box + 2 * m, x, point, active, r, m};
    }
};

struct ExtremePoint {
    NearestPoint problem;
    const double* objective;  // (r), g
    static constexpr auto fields = extended(NearestPoint::fields, "objective(r)");
};

// Write the number of steps; return the status.
CDPR_INLINE int report(double* place, int64_t steps) {
    *place = double(steps);
    return steps < 0 ? int(-steps) : int(OK);
}

// Write the x of least norm.
inline int nearest_point(NearestPoint& p) {
    ActiveSet set = active_set(p.search, p.m + p.r, p.r);
    return report(p.steps, nearest(p.polytope(), set));
}

// Write the x that minimises g . x, with the least norm if there are several.
inline int extreme_point(ExtremePoint& extreme_of) {
    NearestPoint& p = extreme_of.problem;
    ActiveSet set = active_set(p.search, p.m + p.r, p.r);
    return report(p.steps, extreme(p.polytope(), set, extreme_of.objective));
}

}  // namespace cdpr::CDPR_TARGET
