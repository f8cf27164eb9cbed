// Tensions of a point of the null space. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/sum.hpp>
#include <cdpr/tension/tension_problem.hpp>

namespace cdpr::CDPR_TARGET {

// Write t = c + N x, N; x (r).
template <class T> CDPR_INLINE void write_solution(const TensionProblem<T>& problem, int64_t r, const T* x) {
    const Matrix<T> N = problem.N();
    for (int64_t i = 0; i < problem.m; i++)
        problem.tension[i] = sum(problem.center()[i], 0, r, [&](int64_t k) { return N(i, k) * x[k]; });
}

}  // namespace cdpr::CDPR_TARGET
