// Solution of W t = wrench nearest to a point, and its check. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/sum.hpp>
#include <cdpr/tension/null_space.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

// Largest effect of round-off on a solution, as a share of it, for the most ill-conditioned W that `reduce` accepts.
constexpr double PROJECTION_ROUND_OFF = 1e-6;

// Allowed residual of a solution, as a share of the largest row: half of the tolerance of an exact solution.
constexpr double BALANCED = 5e-10;

template <class T> CDPR_INLINE T square(T a) { return a * a; }

// Write t = c + N N^T target, the solution nearest to the target. It is target + W^+ (wrench - W target), computed
// without cancellation: c is orthogonal to N.
template <class T> CDPR_INLINE void nearest_solution(const TensionProblem<T>& problem, int64_t r) {
    const Matrix<T> N = problem.N();
    for (int64_t i = 0; i < problem.m; i++) problem.tension[i] = problem.center()[i];
    for (int64_t k = 0; k < r; k++) {
        const T x = sum(T(0.0), 0, problem.m, [&](int64_t i) { return N(i, k) * problem.target()[i]; });
        for (int64_t i = 0; i < problem.m; i++) problem.tension[i] += N(i, k) * x;
    }
}

// Write the solution nearest to the middle of the limits. Return UNSUPPORTED for an infinite limit, which has no
// middle; INFEASIBLE if the solution is farther from it than the corners of the limits; else OK. All admissible
// tensions lie in the ball through the corners, of radius |t_max - t_min| / 2. (Thesis 6.29 prints t_m / 2, half the
// middle, for (t_max - t_min) / 2; it would reject most feasible wrenches.)
template <class T> CDPR_INLINE T nearest_to_middle(const TensionProblem<T>& problem, int64_t r) {
    Truth<T> bounded = true;
    for (int64_t i = 0; i < problem.m; i++) {
        problem.target()[i] = 0.5 * (problem.low()[i] + problem.high()[i]);
        bounded = bounded & finite(problem.target()[i]);
    }
    if (!any(bounded)) return double(UNSUPPORTED);
    nearest_solution(problem, r);
    const T* t = problem.tension;
    const T outer =
        sum(T(0.0), 0, problem.m, [&](int64_t i) { return square(0.5 * (problem.high()[i] - problem.low()[i])); });
    const T distance = sum(T(0.0), 0, problem.m, [&](int64_t i) { return square(t[i] - problem.target()[i]); });
    const T size = sum(T(0.0), 0, problem.m, [&](int64_t i) { return square(t[i]); });
    const Truth<T> far = square_root(distance) > square_root(outer) + PROJECTION_ROUND_OFF * square_root(size);
    return select(bounded, select(far, T(double(INFEASIBLE)), T(double(OK))), T(double(UNSUPPORTED)));
}

// Clip a solution to the limits; return OK, NOT_FOUND, or INFEASIBLE if it is the only one (r = 0). NOT_FOUND also if
// the clipped solution no longer balances the wrench as exactly as these methods promise.
template <class T> CDPR_INLINE T admitted(const TensionProblem<T>& problem, int64_t r) {
    const T status = clip_to_limits(problem);
    if (r <= 0) return status;
    T lack = 0.0, rows = 0.0;
    for (int64_t j = 0; j < problem.n; j++) {
        const T* row = problem.matrix + j * problem.m;
        const auto part = [&](int64_t i) { return row[i] * problem.tension[i]; };
        lack = larger(lack, absolute(sum(-problem.wrench[j], 0, problem.m, part)));
        const auto size = [&](int64_t i) { return absolute(part(i)); };
        rows = larger(rows, sum(absolute(problem.wrench[j]), 0, problem.m, size));
    }
    const Truth<T> exact = (status == T(double(OK))) & (lack <= BALANCED * rows);
    return select(exact, T(double(OK)), T(double(NOT_FOUND)));
}

}  // namespace cdpr::CDPR_TARGET
