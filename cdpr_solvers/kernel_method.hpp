// Kernel method: one redundant cable, and a null vector that tightens all cables. SPDX-License-Identifier: Apache-2.0
//
// t = t_0 + lambda h with the smallest lambda that brings all cables to their lower limits; t_0 = W^+ wrench (thesis,
// equations 6.33 to 6.35, corrected). See the docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

struct KernelMethod {
    // Return whether h, the first column of N, has one sign. Locked cables do not count.
    static inline bool tightens_all(const TensionProblem<double>& problem) {
        double sign = 0.0;
        for (int64_t i = 0; i < problem.m; i++) {
            if (!(problem.low()[i] < problem.high()[i])) continue;
            const double h = problem.N()(i, 0);
            // The entry of a cable independent of h is round-off.
            if (absolute(h) <= RANK_TOLERANCE || h * sign < 0.0) return false;
            sign = h;
        }
        return true;
    }

    static inline double choose(const TensionProblem<double>& problem, int64_t r) {
        if (r != 1 || !tightens_all(problem)) return UNSUPPORTED;
        const Matrix<double> N = problem.N();
        const double* start = problem.center();
        double factor = 0.0;  // lambda, with the sign of h as it is in N
        for (int64_t i = 0; i < problem.m; i++) {
            const double lacking = problem.low()[i] - start[i];
            if (lacking > factor * N(i, 0)) factor = lacking / N(i, 0);
        }
        for (int64_t i = 0; i < problem.m; i++) problem.tension[i] = start[i] + factor * N(i, 0);
        const double status = clip_to_limits(problem);
        return status != OK && factor == 0.0 ? double(NOT_FOUND) : status;
    }
};

inline int kernel_method(TensionProblem<double>& problem) { return distribute<KernelMethod>(problem); }

}  // namespace cdpr::CDPR_TARGET
