// Improved closed form: cables beyond their limits are fixed there, one by one. SPDX-License-Identifier: Apache-2.0
//
// Pott (2013); thesis, equations 6.30 to 6.32. Fixing cable i at b is a step along n, the part of row i of N orthogonal
// to the rows of the cables fixed before: t += N n (b - t_i) / |n|^2. See the docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/factors.hpp>
#include <cdpr_solvers/projection.hpp>

namespace cdpr::CDPR_TARGET {

// A row of N depends on the rows of the fixed cables if its remainder is shorter than this.
constexpr double FIXED_TOLERANCE = 1e-11;

// Next cable to fix.
struct Worst {
    int64_t cable;  // -1: all are within their limits
    double bound;   // N, the violated limit
    double size;    // length of the remainder of its row of N; 0: it cannot be changed
};

// Return the cable farthest beyond its limits: in newtons, or `scaled` by the remainder of its row of N. The first
// `fixed` columns of N belong to the fixed cables.
inline Worst farthest_beyond(const TensionProblem<double>& problem, int64_t fixed, int64_t r, bool scaled,
                             double tolerance) {
    const Matrix<double> N = problem.N();
    Worst worst = {-1, 0.0, 0.0};
    double most = 0.0;
    for (int64_t i = 0; i < problem.m; i++) {
        const double below = problem.low()[i] - problem.tension[i], above = problem.tension[i] - problem.high()[i];
        const double excess = larger(below, above);
        if (excess <= tolerance) continue;
        const double size = square_root(sum(0.0, fixed, r, [&](int64_t k) { return N(i, k) * N(i, k); }));
        if (!(size > FIXED_TOLERANCE)) return {i, 0.0, 0.0};
        const double measure = scaled ? excess / size : excess;
        if (measure > most) {
            worst = {i, below > above ? problem.low()[i] : problem.high()[i], size};
            most = measure;
        }
    }
    return worst;
}

// Fix a cable at its limit, as number `fixed`, and redistribute the others.
inline void fix(const TensionProblem<double>& problem, int64_t fixed, int64_t r, const Worst& worst) {
    const Matrix<double> N = problem.N();
    turn(N, problem.m, r, fixed, worst.cable, worst.size, problem.target());
    const double step = (worst.bound - problem.tension[worst.cable]) / N(worst.cable, fixed);
    for (int64_t i = 0; i < problem.m; i++) problem.tension[i] += N(i, fixed) * step;
    problem.tension[worst.cable] = worst.bound;
}

// Write the improved closed form; return its status.
inline double closed_form_within_limits(const TensionProblem<double>& problem, int64_t r, bool scaled) {
    const double status = nearest_to_middle(problem, r);
    if (status != OK) return status;
    double largest = 0.0;
    for (int64_t i = 0; i < problem.m; i++) largest = larger(largest, absolute(problem.tension[i]));
    for (int64_t fixed = 0; fixed <= r; fixed++) {
        const Worst worst = farthest_beyond(problem, fixed, r, scaled, VERTEX_TOLERANCE * largest);
        if (worst.cable < 0) return admitted(problem, r);
        if (worst.size == 0.0) return fixed > 0 ? NOT_FOUND : INFEASIBLE;
        fix(problem, fixed, r, worst);
    }
    return NOT_FOUND;
}

struct ImprovedClosedForm {
    TensionProblem<double> problem;
    int64_t scaled;  // 1: the cable with the largest scaled violation is fixed; 0: the one with the largest violation,
                     // as published
    static constexpr auto fields = extended(TensionProblem<double>::fields, "scaled");

    CDPR_INLINE double choose(int64_t r) const { return closed_form_within_limits(problem, r, scaled != 0); }
};

inline int improved_closed_form(ImprovedClosedForm& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
