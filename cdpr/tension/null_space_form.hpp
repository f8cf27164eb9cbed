// Null-space form of a tension distribution problem, as an operation. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/null_space.hpp>

namespace cdpr::CDPR_TARGET {

struct NullSpaceForm {
    const double* matrix;       // (n, m), W, moments in N m per N
    const double* wrench;       // (n), N and N m
    const double* tension_min;  // (m), N
    const double* tension_max;  // (m), N
    double* center;             // (m), N, c
    double* basis;              // (m, m), N in its first `redundancy` columns; the others are undefined
    double* redundancy;         // (1), r
    double* box;                // (4, m), work space
    double* factors;            // (n + 5, n + m), work space
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), center(m), basis(m, m), redundancy(1), "
        "work box(4, m), work factors(n + 5, n + m), n, m";
};

// Write the form; return OK, INFEASIBLE if no tensions exert the wrench, NOT_FOUND if they exceed the range of numbers,
// or BAD_INPUT.
inline int null_space_form(NullSpaceForm& p) {
    double status = OK;
    const TensionProblem<double> problem = {p.matrix, p.wrench, p.tension_min, p.tension_max, p.center, &status,
                                            p.basis,  p.box,    p.factors,     p.n,           p.m};
    const int64_t r = reduce_once(problem);
    *p.redundancy = r < 0 ? 0.0 : double(r);
    if (r < 0) return int(-r);
    for (int64_t i = 0; i < p.m; i++) p.center[i] = problem.center()[i];
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
