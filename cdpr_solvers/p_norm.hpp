// p-norm about the middle of the limits. SPDX-License-Identifier: Apache-2.0
//
// min sum u_i^p with W t = wrench, u_i the offset of t_i from the middle of its limits in half ranges (Gosselin and
// Grenier, Meccanica 46, 2011). Newton's method in the null space, for p = 2, 4, 8, ... up to p, with a line search;
// its steps are weighted least squares. See the docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/solution.hpp>
#include <cdpr_solvers/projection.hpp>
#include <cdpr_solvers/weighted_least_squares.hpp>

namespace cdpr::CDPR_TARGET {

// Final Newton step, in half ranges or of the largest offset if that is more: with quadratic convergence, the error
// after it is round-off. For intermediate p a rough solution is enough.
constexpr double P_CONVERGED = 1e-10, P_ROUGHLY = 1e-2;

// A step below the first value that is not half as long as the previous one is round-off: no further improvement is
// possible.
constexpr double P_NOISE = 1e-6, P_SHRINKING = 0.5;

// Steps that no sound problem needs for one exponent: ten are many.
constexpr int P_MOST_STEPS = 100;

// Offsets below this share of the half range are none: all tensions are in the middle.
constexpr double P_CENTRED = 1e-12;

// A step shorter than this share of Newton's is none.
constexpr double P_SHORTEST = 1e-12;

// u = start + G x, and how it is moved.
struct Offsets {
    Matrix<double> G;  // (m, r), N in half ranges
    double* start;     // (m)
    double* x;         // (r), N
    double* u;         // (m)
    double* v;         // (m), G d
    double* d;         // (r), direction of x
    int64_t m, r;

    // Return the sum of ((u + step v)_i / scale)^p.
    inline double sum_of_powers(int64_t p, double scale, double step) const {
        return sum(0.0, 0, m, [&](int64_t i) { return power((u[i] + step * v[i]) / scale, p); });
    }

    // Return a step of about the length that makes the sum of (u + step v)_i^p least, from Newton's.
    inline double line_search(int64_t p, double scale, double step) const {
        const double here = sum_of_powers(p, scale, 0.0);
        double there = sum_of_powers(p, scale, step);
        if (there < here) {
            // Far away Newton's step is too short by as much as p - 1.
            while (step < 1.0) {
                const double beyond = sum_of_powers(p, scale, 2.0 * step);
                if (!(beyond < there)) break;
                step = 2.0 * step;
                there = beyond;
            }
            return step;
        }
        const double shortest = P_SHORTEST * step;
        while (!(there < here) && step > shortest) {
            step *= 0.5;
            there = sum_of_powers(p, scale, step);
        }
        return step;
    }

    // Write u; return its largest entry.
    inline double write_offsets() const {
        double largest = 0.0;
        for (int64_t i = 0; i < m; i++) {
            u[i] = sum(start[i], 0, r, [&](int64_t k) { return G(i, k) * x[k]; });
            largest = larger(largest, absolute(u[i]));
        }
        return largest;
    }

    // Write v; return its largest entry.
    inline double write_direction() const {
        double largest = 0.0;
        for (int64_t i = 0; i < m; i++) {
            v[i] = sum(0.0, 0, r, [&](int64_t k) { return G(i, k) * d[k]; });
            largest = larger(largest, absolute(v[i]));
        }
        return largest;
    }

    // Move x to where the sum of u_i^p is least; return whether it was reached.
    inline bool minimise(int64_t p, double goal, const WeightedLeastSquares& squares) const {
        double previous = INFINITE;
        for (int trial = 0; trial < P_MOST_STEPS; trial++) {
            const double scale = write_offsets();
            if (scale <= P_CENTRED) return true;
            squares.solve(p, scale, G, u, d);
            const double longest = write_direction();
            // The Hessian of the sum is p - 1 times the normal matrix of the weighted least squares.
            double step = 1.0 / double(p - 1);
            const double newton = longest * step / larger(1.0, scale);
            if (!(newton < INFINITE)) return false;  // NaN, too
            const bool done = newton <= goal || (newton <= P_NOISE && newton > P_SHRINKING * previous);
            previous = newton;
            if (!done) step = line_search(p, scale, step);
            for (int64_t k = 0; k < r; k++) x[k] += step * d[k];
            if (done) return true;
        }
        return false;
    }
};

struct PNorm {
    TensionProblem<double> problem;
    double* space;  // (3 m + 8, m), work space
    int64_t p;      // even, at least 2
    static constexpr auto fields = extended(TensionProblem<double>::fields, "work space(3*m + 8, m), p");

    // Write the offsets at x = 0; locked cables stay at 0. Return whether all ranges are finite.
    inline bool begin(const Offsets& offsets) const {
        for (int64_t i = 0; i < problem.m; i++) {
            const double low = problem.low()[i], high = problem.high()[i], half = 0.5 * (high - low);
            if (half == INFINITE) return false;
            offsets.start[i] = half > 0.0 ? (problem.center()[i] - 0.5 * (low + high)) / half : 0.0;
            for (int64_t k = 0; k < offsets.r; k++) offsets.G(i, k) = half > 0.0 ? problem.N()(i, k) / half : 0.0;
        }
        for (int64_t k = 0; k < offsets.r; k++) offsets.x[k] = 0.0;
        return true;
    }

    inline double choose(int64_t r) const {
        const int64_t m = problem.m;
        const Matrix<double> G = {space, m}, rows = G.from(m);
        const Offsets offsets = {G, rows[0], rows[1], rows[2], rows[3], rows[4], m, r};
        const WeightedLeastSquares squares = {
            rows.from(5), rows.from(5 + r), rows[5 + 2 * r], rows[6 + 2 * r], rows[7 + 2 * r], m, r};
        if (!begin(offsets)) return UNSUPPORTED;
        for (int64_t now = 2; r > 0; now = 2 * now < p ? 2 * now : p) {
            if (!offsets.minimise(now, now == p ? P_CONVERGED : P_ROUGHLY, squares)) return NOT_FOUND;
            if (now == p) break;
        }
        write_solution(problem, r, offsets.x);
        return admitted(problem, r);
    }
};

inline int p_norm(PNorm& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
