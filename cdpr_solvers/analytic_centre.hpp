// Analytic centre of the admissible tensions. SPDX-License-Identifier: Apache-2.0
//
// min -sum w_i [log(t_i - t_min,i) + log(t_max,i - t_i)] with W t = wrench. In a practically flat set, the cables
// across it are locked, and the others have a centre of their own. See the docstring of the module.
#pragma once

#include <cdpr/tension/null_space.hpp>
#include <cdpr/tension/safest.hpp>
#include <cdpr/tension/solution.hpp>
#include <cdpr/tension/verdict.hpp>
#include <cdpr_solvers/barrier.hpp>

namespace cdpr::CDPR_TARGET {

// A set of admissible tensions thinner than this share of the largest tension is practically flat: the cables across it
// have the tensions of the largest ball's centre, and all admissible tensions differ from these by no more. Some
// hundred times the round-off of the tensions themselves.
constexpr double THIN = 1e-12;

// Range of a tension across such a set: the ball's diameter, or more if limits meet at an angle.
constexpr double WIDEST = 100.0;

// Below this share the set may be so much longer than wide that the Hessian, made of inverse squares of distances,
// loses the long directions to round-off, unless the basis is rotated to separate them.
constexpr double FLAT = 1e-4;

struct AnalyticCentre {
    TensionProblem<double> problem;
    const double* weights;  // (m), of the cables in the barrier, positive
    double* turned;         // (m + 1, m), work space: N and x, rotated together
    double* limits;         // (3, m), work space: the limits, with more cables locked, and the centre
    double* space;          // (4 m + 17, 2 m + 1), work space
    static constexpr auto fields =
        extended(TensionProblem<double>::fields,
                 "weights(m), work turned(m + 1, m), work limits(3, m), work space(4*m + 17, 2*m + 1)");

    CDPR_INLINE double* low() const { return limits; }
    CDPR_INLINE double* high() const { return limits + problem.m; }
    CDPR_INLINE double* x() const { return turned + problem.m * problem.m; }

    // Return the problem with more cables locked.
    CDPR_INLINE TensionProblem<double> locked() const {
        TensionProblem<double> inner = problem;
        inner.tension_min = low();
        inner.tension_max = high();
        inner.basis = turned;
        inner.tension = limits + 2 * problem.m;
        return inner;
    }

    inline double find() const;
    inline double move_to_ball(const TensionProblem<double>& inner, int64_t r) const;
    inline bool reach_centre(const TensionProblem<double>& inner, int64_t r, bool flat) const;
    inline int64_t go_to_end(const TensionProblem<double>& inner, int64_t r, int64_t i, double sign) const;
    inline bool endless(const TensionProblem<double>& inner, int64_t r) const;
    inline bool lock(const TensionProblem<double>& inner, int64_t r, double thin) const;
};

// Add N x to c, the centre of the ball, and return the largest of these tensions: steps from there are not rounded by
// its size.
inline double AnalyticCentre::move_to_ball(const TensionProblem<double>& inner, int64_t r) const {
    double largest = 0.0;
    for (int64_t i = 0; i < inner.m; i++) {
        double* c = inner.center() + i;
        *c = sum(*c, 0, r, [&](int64_t k) { return inner.N()(i, k) * x()[k]; });
        largest = larger(largest, absolute(*c));
    }
    for (int64_t k = 0; k < r; k++) x()[k] = 0.0;
    return largest;
}

// Move x from zero to the centre; return whether it was reached. A set that is not `flat` here may be flat elsewhere,
// with a very distant limit.
inline bool AnalyticCentre::reach_centre(const TensionProblem<double>& inner, int64_t r, bool flat) const {
    const Matrix<double> rows = {space, 2 * inner.m + 1};
    const Barrier barrier = {inner.N(), inner.center(), inner.low(), inner.high(), weights,
                             x(),       rows,           rows[r],     inner.m,      r};
    if (barrier.minimise(flat)) return true;
    if (flat) return false;
    for (int64_t k = 0; k < r; k++) x()[k] = 0.0;
    return barrier.minimise(true);
}

// Write the admissible tensions, into row 2 of the space, with the smallest value of sign times that of one cable;
// return as `extreme`. x does not change.
inline int64_t AnalyticCentre::go_to_end(const TensionProblem<double>& inner, int64_t r, int64_t i, double sign) const {
    const Matrix<double> rows = {space, 2 * inner.m + 1};
    const Matrix<const double> N = {inner.basis, inner.m};
    const Polytope<double> set = {N, inner.center(), inner.low(), inner.high(), rows[1], rows[2], rows[3], r, inner.m};
    for (int64_t k = 0; k < r; k++) rows[0][k] = sign * N(i, k);
    ActiveSet active = active_set(rows[4], rows.stride, r);
    return extreme(set, active, rows[0]);
}

// Return whether some tension is unbounded towards an infinite limit: the barrier then has no minimum.
inline bool AnalyticCentre::endless(const TensionProblem<double>& inner, int64_t r) const {
    for (int64_t i = 0; i < inner.m; i++) {
        if (inner.low()[i] == -INFINITE && go_to_end(inner, r, i, 1.0) == -UNSUPPORTED) return true;
        if (inner.high()[i] == INFINITE && go_to_end(inner, r, i, -1.0) == -UNSUPPORTED) return true;
    }
    return false;
}

// Lock the cables with tensions that can change by no more than round-off; return whether there are any. A practically
// flat set may still be long: its centre is that of the other cables. `thin` is in N.
inline bool AnalyticCentre::lock(const TensionProblem<double>& inner, int64_t r, double thin) const {
    const Matrix<const double> N = {inner.basis, inner.m};
    const double* point = Matrix<double>{space, 2 * inner.m + 1}[2];
    bool found = false;
    for (int64_t i = 0; i < inner.m; i++) {
        double middle = 0.0, span = 0.0;
        bool moves = false;
        for (int64_t k = 0; k < r; k++) moves = moves || N(i, k) != 0.0;
        if (!moves) continue;
        for (int side = 0; side < 2; side++) {
            if (go_to_end(inner, r, i, side == 0 ? 1.0 : -1.0) < 0) return false;
            middle += 0.5 * point[i];
            span += side == 1 ? point[i] : -point[i];
        }
        if (!(span <= WIDEST * thin)) continue;
        low()[i] = high()[i] = smaller(larger(middle, inner.low()[i]), inner.high()[i]);
        found = true;
    }
    return found;
}

// Write the tensions; return their status.
inline double AnalyticCentre::find() const {
    const TensionProblem<double> inner = locked();
    const int64_t m = problem.m;
    for (int64_t i = 0; i < m; i++) {
        low()[i] = problem.tension_min[i];
        high()[i] = problem.tension_max[i];
    }
    double status = NOT_FOUND;
    for (int64_t round = 0; round < m; round++) {  // each round locks at least one more cable
        const int64_t r = reduce(inner);
        if (r < 0) return round > 0 ? status : double(-r);
        const double radius = safest_point(true, polytope_of<double>(inner, r, x(), nullptr), space);
        if (radius != radius) return status;
        if (r > 0 && (radius == INFINITE || endless(inner, r))) return UNSUPPORTED;
        const double largest = move_to_ball(inner, r);
        const bool thin = r > 0 && !(radius > THIN * largest);
        if (r > 0 && !thin && !reach_centre(inner, r, radius < FLAT * largest)) return status;
        for (int64_t i = 0; i < m; i++) {
            inner.low()[i] = problem.tension_min[i];
            inner.high()[i] = problem.tension_max[i];
        }
        write_solution(inner, r, x());
        const double settled = clip_to_limits(inner);
        if (settled == OK || round == 0) {
            status = settled;
            for (int64_t i = 0; i < m; i++) problem.tension[i] = inner.tension[i];
        }
        if (!thin || status != OK || !lock(inner, r, THIN * largest)) break;
    }
    return status;
}

inline int analytic_centre(AnalyticCentre& solver) {
    *solver.problem.status = solver.find();
    return int(*solver.problem.status);
}

}  // namespace cdpr::CDPR_TARGET
