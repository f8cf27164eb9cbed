// Minimum 1-norm within the limits, a linear program (thesis, equation 6.24). SPDX-License-Identifier: Apache-2.0
//
// min sum w_i t_i; if there are several optima, that of least 2-norm.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/extreme_point.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

struct MinimumSum {
    TensionProblem<double> problem;
    const double* weights;  // (m), cost of each tension
    double* space;          // (2 m + 11, m), work space
    static constexpr auto fields = extended(TensionProblem<double>::fields, "weights(m), work space(2*m + 11, m)");

    // Write the cost of x (r), g . x: 0 for round-off, if all solutions have the same cost.
    inline void write_cost(int64_t r, double* g) const {
        const Matrix<double> N = problem.N();
        for (int64_t k = 0; k < r; k++) {
            const auto part = [&](int64_t i) { return N(i, k) * weights[i]; };
            const double terms = sum(0.0, 0, problem.m, [&](int64_t i) { return absolute(part(i)); });
            g[k] = sum(0.0, 0, problem.m, part);
            if (absolute(g[k]) <= ROUNDING * terms) g[k] = 0.0;
        }
    }

    inline double choose(int64_t r) const {
        const Matrix<double> rows = {space, problem.m};
        double *x = rows[0], *active = rows[1], *g = rows[2];
        write_cost(r, g);
        ActiveSet limits = active_set(rows[3], problem.m, r);
        const int64_t steps = extreme(polytope_of(problem, r, x, active), limits, g);
        return steps < 0 ? double(-steps) : verdict(problem, r, x);
    }
};

inline int minimum_sum(MinimumSum& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
