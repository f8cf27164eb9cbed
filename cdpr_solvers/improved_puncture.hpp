// Improved puncture method: low tensions, few failures. SPDX-License-Identifier: Apache-2.0
//
// Like puncture.hpp, but towards the improved closed form. See the docstring of the module.
#pragma once

#include <cdpr_solvers/improved_closed_form.hpp>
#include <cdpr_solvers/puncture.hpp>

namespace cdpr::CDPR_TARGET {

struct ImprovedPuncture {
    static inline double choose(const TensionProblem<double>& problem, int64_t r) {
        TensionProblem<double> closed = problem;
        closed.tension = problem.spare();
        const double status = closed_form_within_limits(closed, r, false);
        return status == OK ? least_step(problem, 1, closed.tension) : status;
    }
};

inline int improved_puncture(TensionProblem<double>& problem) { return distribute<ImprovedPuncture>(problem); }

}  // namespace cdpr::CDPR_TARGET
