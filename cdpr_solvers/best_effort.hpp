// Tensions within the limits with the wrench nearest to the required one. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/box_least_squares.hpp>

namespace cdpr::CDPR_TARGET {

// Return whether tensions of least norm balance the wrench within the limits, and write them then; BAD_INPUT as
// `reduce`.
CDPR_INLINE int balance(const BoxLeastSquares& p) {
    const TensionProblem<double> problem = p.problem(p.wrench, p.tension);
    const int64_t r = reduce(problem);
    if (r < 0) return int(-r);
    ActiveSet set = active_set(p.space.search, p.m, r);
    const int64_t steps = nearest(polytope_of(problem, r, p.x(), p.active()), set);
    return steps < 0 ? int(-steps) : int(verdict(problem, r, p.x()));
}

// Write the nearest tensions; return OK, INFEASIBLE, UNSUPPORTED, NOT_FOUND or BAD_INPUT. For a feasible wrench they
// are those of `minimum_norm`.
inline int best_effort(BoxLeastSquares& p) {
    int status = balance(p);
    *p.steps = 0.0;
    if (status != OK && status != BAD_INPUT) {
        const int found = box_least_squares(p);
        status = found == OK ? int(INFEASIBLE) : found;
    }
    *p.status = status;
    return status;
}

}  // namespace cdpr::CDPR_TARGET
