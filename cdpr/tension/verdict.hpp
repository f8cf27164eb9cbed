// Verdict on tensions: admissible or not. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/sum.hpp>
#include <cdpr/tension/checks.hpp>
#include <cdpr/tension/tension_problem.hpp>

namespace cdpr::CDPR_TARGET {

// A violation of a limit below this share of the largest tension is the round-off of an ill-conditioned problem whose
// only solution is a vertex: the band within which round-off decides feasibility.
constexpr double VERTEX_TOLERANCE = 1e-9;

// Below this share it is the round-off of any regular problem: the balance is as good as possible.
constexpr double BREACH_ROUND_OFF = 1e-12;

// Beyond that the tensions, moved onto the limits, must still balance each row to this share of the tolerance of the
// tension stage, which weighs moments by a length that is unknown here.
constexpr double STRICTER = 0.1;

// Share of the largest tension that replaces a newton in the allowed residual from 1 kN on: the residual of moving a
// tension onto a limit by round-off grows with the tensions.
constexpr double LARGE = 1e-3;

// The larger one, NaN if either is NaN.
template <class T> CDPR_INLINE T larger_or_nan(T a, T b) { return select((b <= a) | (a != a), a, b); }

// Return whether tensions that were moved onto the limits still balance each row; `largest` is the largest of them, N.
template <class T> CDPR_INLINE Truth<T> balances(const TensionProblem<T>& problem, T largest) {
    Truth<T> balanced = true;
    const T one = larger(T(1.0), LARGE * largest);
    for (int64_t j = 0; j < problem.n; j++) {
        const T* row = problem.matrix + j * problem.m;
        const T s = sum(-problem.wrench[j], 0, problem.m, [&](int64_t i) { return row[i] * problem.tension[i]; });
        T size = 0.0;
        for (int64_t i = 0; i < problem.m; i++) size = larger(size, absolute(row[i]));
        const T scale = larger(absolute(problem.wrench[j]), one * smaller(size, T(1.0)));
        balanced = balanced & (absolute(s) <= STRICTER * RESIDUAL_TOLERANCE * scale);
        if (!any(balanced)) return balanced;
    }
    return balanced;
}

// Return whether tensions within the limits are accepted if they differ by `breach` from a solution of magnitude
// `size`: the single decision for all methods in the null space.
template <class T> CDPR_INLINE Truth<T> answers(const TensionProblem<T>& problem, T breach, T size) {
    const Truth<T> near = breach <= VERTEX_TOLERANCE * size, close = breach <= BREACH_ROUND_OFF * size;
    if (all(close)) return close;
    return any(near) ? close | (near & balances(problem, size)) : close;
}

// Largest difference of tensions from a solution, and the magnitude of that solution.
template <class T> struct Difference {
    T breach, size;
};

// Compare `tension` with the solution c + N x.
template <class T> CDPR_INLINE Difference<T> compared(const TensionProblem<T>& problem, int64_t r, const T* x) {
    const Matrix<T> N = problem.N();
    Difference<T> found = {0.0, 0.0};
    for (int64_t i = 0; i < problem.m; i++) {
        const T s = sum(problem.center()[i], 0, r, [&](int64_t k) { return N(i, k) * x[k]; });
        found.size = larger(found.size, absolute(s));
        found.breach = larger_or_nan(found.breach, absolute(s - problem.tension[i]));
    }
    return found;
}

// Return OK if `tension`, within the limits, is the solution c + N x of W t = wrench, else INFEASIBLE.
template <class T> CDPR_INLINE T verdict(const TensionProblem<T>& problem, int64_t r, const T* x) {
    const Difference<T> found = compared(problem, r, x);
    return select(answers(problem, found.breach, found.size), T(double(OK)), T(double(INFEASIBLE)));
}

// Return OK if `tension`, a solution of W t = wrench, is within the limits, else INFEASIBLE. Tensions with an
// acceptable violation are moved onto the limits.
template <class T> CDPR_INLINE T clip_to_limits(const TensionProblem<T>& problem) {
    T breach = 0.0, size = 0.0;
    for (int64_t i = 0; i < problem.m; i++) {
        const T t = problem.tension[i];
        size = larger(size, absolute(t));
        breach = larger_or_nan(breach, larger(problem.low()[i] - t, t - problem.high()[i]));
    }
    const Truth<T> near = breach <= VERTEX_TOLERANCE * size;
    if (!any(near)) return double(INFEASIBLE);
    for (int64_t i = 0; i < problem.m; i++) {
        T* t = problem.tension + i;
        *t = select(near, smaller(larger(*t, problem.low()[i]), problem.high()[i]), *t);
    }
    return select(answers(problem, breach, size), T(double(OK)), T(double(INFEASIBLE)));
}

}  // namespace cdpr::CDPR_TARGET
