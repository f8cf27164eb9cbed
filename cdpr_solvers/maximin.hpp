// Distribution farthest from the limits. SPDX-License-Identifier: Apache-2.0
//
// max s with W t = wrench and t_min + s d <= t <= t_max - s d: with the largest slack (Borgstrom et al. 2009), or the
// centre of the largest ball. See the docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/safest.hpp>
#include <cdpr/tension/solution.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

struct Maximin {
    TensionProblem<double> problem;
    double* space;  // (4 m + 17, 2 m + 1), work space
    int64_t ball;   // 1: the centre of the largest ball; 0: the largest slack
    static constexpr auto fields = extended(TensionProblem<double>::fields, "work space(4*m + 17, 2*m + 1), ball");

    inline double choose(int64_t r) const {
        double* x = problem.spare();
        const double margin = safest_point(ball != 0, polytope_of<double>(problem, r, x, nullptr), space);
        if (margin != margin) return NOT_FOUND;
        if (margin == INFINITE && r > 0) return UNSUPPORTED;  // unbounded
        write_solution(problem, r, x);
        return clip_to_limits(problem);
    }
};

inline int maximin(Maximin& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
