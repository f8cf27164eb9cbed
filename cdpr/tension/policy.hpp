// Replacement of an inadmissible answer of a solver. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/box_least_squares.hpp>
#include <cdpr/tension/checks.hpp>

namespace cdpr::CDPR_TARGET {

// Replacement by a policy: the tensions with the nearest wrench within the limits; those of the previous step; or the
// solver's own, clipped to the limits, if they are finite.
enum Action { NEAREST, HOLD, CLIP };

struct Fallback {
    const double* matrix;   // (n, m), moments in N m per N
    const double* wrench;   // (n), N and N m
    const double* weights;  // (n), 1 for forces, 1 / characteristic length, 1/m, for moments
    const double* limits;   // (2, m), N
    int64_t* known;   // (2): whether the solver has written anything into its answer; whether the report is that of
                      // its rejected answer: the check that failed
    double* answer;   // (m), N, of the solver, NaN if it wrote none; replaced
    double* tension;  // (m), N, of the previous step; replaced
    double* report;   // (4): status; residual, N; margin, N; number of cables at a limit
    double* steps;    // (1), work space
    BoxLeastSquaresSpace space;
    int64_t action;    // an Action
    int64_t answered;  // whether the solver gave an answer, which failed the checks
    int64_t n;
    int64_t m;
    static constexpr auto fields = join(
        "matrix(n, m), wrench(n), weights(n), limits(2, m), both known(2), both answer(m), both tension(m), "
        "both report(4), work steps(1), ",
        BoxLeastSquaresSpace::fields, ", action, answered, n, m");

    CDPR_INLINE BoxLeastSquares nearest() const {
        return {matrix, wrench, limits, limits + m, weights, tension, report, steps, space, n, m};
    }
};

// Replace the tensions of the previous step, and write the report of the new ones, with the solver's status. Return
// false, and change nothing, if an input is not finite.
inline bool fall_back(const Fallback& p, double status) {
    if (!all_finite(p.wrench, p.n) || !all_finite(p.matrix, p.n * p.m)) return false;
    if (p.action == CLIP && all_finite(p.answer, p.m)) {
        for (int64_t i = 0; i < p.m; i++) p.tension[i] = p.answer[i];
    } else if (p.action != HOLD) {
        // If the iteration fails, its last tensions are the best known.
        BoxLeastSquares nearest = p.nearest();
        box_least_squares(nearest);
    }
    for (int64_t i = 0; i < p.m; i++) p.tension[i] = smaller(larger(p.tension[i], p.limits[i]), p.limits[p.m + i]);
    Acceptance<double> judged = {p.matrix, p.wrench, p.weights, p.limits, p.tension, p.tension, p.report, p.n, p.m};
    holds(judged, true);
    p.report[0] = status;
    return true;
}

// Replace tensions and answer if the solver gave no answer, or a rejected one; return OK. Return the solver's status,
// which is passed in place of the time, and replace nothing, if Python has to report: it is no status, an input is not
// finite, or this is the first rejected answer.
inline int replace_tension(Fallback& p, double solver_status) {
    const int status = int(solver_status);
    for (int64_t i = 0; i < p.m; i++)
        if (p.answer[i] == p.answer[i]) p.known[0] = 1;
    const bool untold = p.answered && status == NOT_FOUND && p.known[1] == 0;
    if (status <= OK || status > BAD_INPUT || untold) return status;
    if (!fall_back(p, double(status))) return status;
    for (int64_t i = 0; i < p.m; i++) p.answer[i] = p.tension[i];
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
