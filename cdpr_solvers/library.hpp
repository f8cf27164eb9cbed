// Problem in the form for libraries, and the check of their answers. SPDX-License-Identifier: Apache-2.0
//
// low <= N x <= high in the null space, t = c + N x, in units of the largest limit. See the docstring of the module.
#pragma once

#include <cdpr/tension/active_set.hpp>
#include <cdpr/tension/null_space.hpp>
#include <cdpr/tension/solution.hpp>

namespace cdpr::CDPR_TARGET {

// Accepted violation of the limits by a library's answer, as a share of the largest limit: above the tolerances given
// to libraries, below anything measurable.
constexpr double BELIEVED = 2.0 * VERTEX_TOLERANCE;

// A limit beyond this multiple of any optimum is reduced to it: far enough not to affect any method.
constexpr double BEYOND = 16.0;

struct LibraryProblem {
    const double* matrix;       // (n, m), W, moments in N m per N
    const double* wrench;       // (n), N and N m
    const double* tension_min;  // (m), N
    const double* tension_max;  // (m), N
    double* tension;            // (m), N, the admissible tensions of least norm
    double* packed;             // (m m), N (m, r) without gaps between its rows
    double* bounds;             // (2, m), low and high in units
    double* redundancy;         // (1), r
    double* unit;               // (1), N, a power of two
    double* basis;              // (m, m), N, for LibraryAnswer
    double* box;                // (4, m), c and the limits, N, for LibraryAnswer
    double* factors;            // (n + 5, n + m), work space
    double* search;             // (2 m + 8, m), work space: active set
    double* vectors;            // (2, m), work space: x, and which limits are active
    double wider;               // share of the largest limit by which the bounds are wider than the limits
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), tension(m), packed(m*m), bounds(2, m), "
        "redundancy(1), unit(1), basis(m, m), box(4, m), work factors(n + 5, n + m), work search(2*m + 8, m), "
        "work vectors(2, m), wider, n, m";

    // Return the problem, without an output for the status.
    CDPR_INLINE TensionProblem<double> problem() const {
        return {matrix, wrench, tension_min, tension_max, tension, nullptr, basis, box, factors, n, m};
    }
};

// Return the largest power of two that is not above x > 0, division by which is exact; 1 for 0.
inline double power_of_two(double x) {
    int exponent = 0;
    if (!(x > 0.0)) return 1.0;
    ::frexp(x, &exponent);
    return ::ldexp(0.5, exponent);
}

// Return whether x changes a cable.
CDPR_INLINE bool moves(const Matrix<double>& N, int64_t i, int64_t r) {
    for (int64_t k = 0; k < r; k++)
        if (N(i, k) != 0.0) return true;
    return false;
}

// Return the largest relevant limit, N: no optimum, of the norm or the sum, has a tension beyond 1 / BEYOND of it.
// Larger limits would determine the library's unit, and the tensions would be lost in its tolerance. 0 without any
// tensions. Locked cables are not passed to the library.
inline double reach(const LibraryProblem& p) {
    double largest = 0.0, lowest = 0.0, square = 0.0, spare = 0.0;
    for (int64_t i = 0; i < p.m; i++) {
        if (!(p.tension_min[i] < p.tension_max[i])) continue;
        largest = larger(larger(largest, absolute(p.tension_min[i])), absolute(p.tension_max[i]));
        lowest = larger(lowest, absolute(p.tension_min[i]));
        square += p.tension[i] * p.tension[i];
        spare += p.tension[i] - p.tension_min[i];
    }
    const double farthest = BEYOND * larger(square_root(square), spare + lowest);
    return farthest == 0.0 ? 0.0 : smaller(largest, farthest);
}

// Write N and the bounds of N x.
inline void write_bounds(const LibraryProblem& p, int64_t r, double largest) {
    const Matrix<double> N = {p.basis, p.m};
    *p.unit = power_of_two(largest);
    for (int64_t i = 0; i < p.m; i++) {
        for (int64_t k = 0; k < r; k++) p.packed[i * r + k] = N(i, k);
        const bool free = moves(N, i, r);
        p.bounds[i] = free ? (p.tension_min[i] - p.box[i]) / *p.unit - p.wider : -1.0;
        p.bounds[p.m + i] = free ? (smaller(p.tension_max[i], largest) - p.box[i]) / *p.unit + p.wider : 1.0;
    }
}

// Write the problem. Return OK and r; r = 0 if the solution is unique. Else INFEASIBLE without admissible tensions,
// NOT_FOUND or BAD_INPUT.
inline int library_problem(LibraryProblem& p) {
    *p.redundancy = 0.0;
    for (int64_t i = 0; i < p.m; i++)
        if (!finite(p.tension_min[i]) || !finite(p.tension_max[i])) return BAD_INPUT;
    const TensionProblem<double> problem = p.problem();
    const int64_t r = reduce_once(problem);
    if (r < 0) return int(-r);
    ActiveSet set = active_set(p.search, p.m, r);
    const int64_t steps = nearest(polytope_of(problem, r, p.vectors, p.vectors + p.m), set);
    if (steps < 0) return int(-steps);
    const int status = int(verdict(problem, r, p.vectors));
    if (status != OK) return status;
    const double largest = reach(p);
    if (largest == 0.0) return OK;  // all tensions are zero, the smallest ones
    write_bounds(p, r, largest);
    *p.redundancy = double(r);
    return OK;
}

struct LibraryAnswer {
    const double* matrix;       // (n, m), as in LibraryProblem, and so on
    const double* wrench;       // (n)
    const double* tension_min;  // (m)
    const double* tension_max;  // (m)
    const double* x;            // (m), the library's solution in its first r entries, units
    const double* redundancy;   // (1), r
    const double* unit;         // (1)
    double* tension;            // (m), N, the admissible tensions of least norm, then the answer
    double* basis;              // (m, m)
    double* box;                // (4, m)
    double* factors;            // (n + 5, n + m), work space
    double* search;             // (2 m + 8, m), work space: active set
    double* vectors;            // (3, m), work space: x, which limits are active, tensions
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), x(m), redundancy(1), unit(1), both tension(m), "
        "both basis(m, m), both box(4, m), work factors(n + 5, n + m), work search(2*m + 8, m), work vectors(3, m), n, "
        "m";

    CDPR_INLINE double* nearest_x() const { return vectors; }
    CDPR_INLINE double* point() const { return vectors + 2 * m; }
    CDPR_INLINE TensionProblem<double> problem() const {
        return {matrix, wrench, tension_min, tension_max, point(), nullptr, basis, box, factors, n, m};
    }
};

// Return whether the library's tensions are those of least norm except for round-off.
inline bool is_least(const LibraryAnswer& p) {
    bool same = true;
    for (int64_t i = 0; i < p.m; i++) same = same && absolute(p.point()[i] - p.tension[i]) <= BELIEVED * *p.unit;
    return same;
}

// Return whether the library's tensions violate a limit by more than round-off; also for NaN.
inline bool breaks_limits(const LibraryAnswer& p, int64_t r) {
    const Matrix<double> N = {p.basis, p.m};
    for (int64_t i = 0; i < p.m; i++) {
        const double t = p.point()[i], excess = larger(p.box[p.m + i] - t, t - p.box[2 * p.m + i]);
        if (moves(N, i, r) && !(excess <= BELIEVED * *p.unit)) return true;
    }
    return false;
}

// Write the admissible tensions nearest to the library's answer; return OK, or NOT_FOUND if it violates the limits.
inline int library_answer(LibraryAnswer& p) {
    const int64_t r = int64_t(*p.redundancy);
    if (!(r >= 0 && r <= p.m)) return BAD_INPUT;
    const TensionProblem<double> problem = p.problem();
    for (int64_t k = 0; k < r; k++) p.nearest_x()[k] = *p.unit * p.x[k];
    write_solution(problem, r, p.nearest_x());
    if (is_least(p)) return OK;
    if (breaks_limits(p, r)) return NOT_FOUND;
    for (int64_t i = 0; i < p.m; i++) p.box[i] = p.point()[i];
    ActiveSet set = active_set(p.search, p.m, r);
    if (nearest(polytope_of(problem, r, p.nearest_x(), p.vectors + p.m), set) < 0) return NOT_FOUND;
    if (verdict(problem, r, p.nearest_x()) != OK) return NOT_FOUND;
    for (int64_t i = 0; i < p.m; i++) p.tension[i] = p.point()[i];
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
