// Puncture method: low tensions in closed form. SPDX-License-Identifier: Apache-2.0
//
// t = t_0 + s (t_c - t_0) with the smallest s in [0, 1] within the limits; t_0 = W^+ wrench, and t_c the closed form
// (Mueller, Reichert and Bruckmann 2015). See the docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr_solvers/projection.hpp>

namespace cdpr::CDPR_TARGET {

// Write the first point within the limits on the way from the least norm to `end` (m), N; return as `admitted`.
inline double least_step(const TensionProblem<double>& problem, int64_t r, const double* end) {
    const double* start = problem.center();
    double s = 0.0, size = 0.0;
    for (int64_t i = 0; i < problem.m; i++) size = larger(size, absolute(end[i]));
    for (int64_t i = 0; i < problem.m; i++) {
        const double lacking = larger(problem.low()[i] - start[i], 0.0) + smaller(problem.high()[i] - start[i], 0.0);
        // A step that `settle` does not require would be a quotient of round-off.
        if (absolute(lacking) > VERTEX_TOLERANCE * size && lacking * (end[i] - start[i]) > 0.0)
            s = larger(s, lacking / (end[i] - start[i]));
    }
    s = smaller(s, 1.0);
    for (int64_t i = 0; i < problem.m; i++) problem.tension[i] = start[i] + s * (end[i] - start[i]);
    return admitted(problem, r);
}

struct Puncture {
    static inline double choose(const TensionProblem<double>& problem, int64_t r) {
        TensionProblem<double> closed = problem;
        closed.tension = problem.spare();
        const double status = nearest_to_middle(closed, r);
        return status == OK ? least_step(problem, r, closed.tension) : status;
    }
};

inline int puncture(TensionProblem<double>& problem) { return distribute<Puncture>(problem); }

}  // namespace cdpr::CDPR_TARGET
