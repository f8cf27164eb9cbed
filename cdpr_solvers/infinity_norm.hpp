// Minimum infinity norm within the limits, a linear program. SPDX-License-Identifier: Apache-2.0
//
// min s with t = c + N x within its limits and -s <= t <= s; if there are several optima, that of least 2-norm. See the
// docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/linear_program.hpp>
#include <cdpr/tension/solution.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

struct MinimumLargest {
    TensionProblem<double> problem;
    double* space;  // (5 m + 17, 3 m + 1), work space
    static constexpr auto fields = extended(TensionProblem<double>::fields, "work space(5*m + 17, 3*m + 1)");

    inline double choose(int64_t r) const {
        const Matrix<const double> N = {problem.basis, problem.m};
        LinearProgram program = linear_program(space, 3 * problem.m, r);
        for (int64_t i = 0; i < problem.m; i++) {
            const double c = problem.center()[i], low = problem.low()[i], high = problem.high()[i];
            if (low != high) program.add(N, i, 0.0, c, low, high);
            program.add(N, i, -1.0, c, -INFINITE, 0.0);               // t <= s
            if (low < 0.0) program.add(N, i, 1.0, c, 0.0, INFINITE);  // -t <= s, if it may be negative
        }
        const int64_t steps = program.solve(1.0);
        if (steps < 0) return double(-steps);
        write_solution(problem, r, program.y);
        return clip_to_limits(problem);
    }
};

inline int minimum_largest(MinimumLargest& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
