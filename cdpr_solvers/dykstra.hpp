// Alternating projections between the solutions of W t = wrench and the limits. SPDX-License-Identifier: Apache-2.0
//
// Start in the middle of the limits; alternately project on { W t = wrench } and, after adding the change of the last
// projection on the limits, on the limits: Boyle and Dykstra (1986); for cables, Hassan and Khajepour (2011). The
// affine set needs no correction. See the docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr_solvers/projection.hpp>

namespace cdpr::CDPR_TARGET {

struct Dykstra {
    TensionProblem<double> problem;
    int64_t iterations;  // largest number of pairs of projections
    double tolerance;    // allowed violation of the limits before clipping, share of the largest
    static constexpr auto fields = extended(TensionProblem<double>::fields, "iterations, tolerance");

    inline double choose(int64_t r) const;
    inline void project_on_limits(double* correction) const;
    inline bool close(double largest) const;
};

// Write the point of the limits nearest to the tensions plus the correction, and the next correction.
inline void Dykstra::project_on_limits(double* correction) const {
    for (int64_t i = 0; i < problem.m; i++) {
        const double s = problem.tension[i] + correction[i];
        problem.target()[i] = smaller(larger(s, problem.low()[i]), problem.high()[i]);
        correction[i] = s - problem.target()[i];
    }
}

// Return whether the solution is close enough to the point of the limits; `largest` is the largest limit, N.
inline bool Dykstra::close(double largest) const {
    double apart = 0.0;
    for (int64_t i = 0; i < problem.m; i++) apart = larger(apart, absolute(problem.tension[i] - problem.target()[i]));
    return apart <= tolerance * largest;
}

inline double Dykstra::choose(int64_t r) const {
    double* correction = problem.spare();
    const double status = nearest_to_middle(problem, r);
    if (status != OK) return status;
    double largest = 0.0;
    bool within = true;
    for (int64_t i = 0; i < problem.m; i++) {
        const double low = problem.low()[i], high = problem.high()[i];
        correction[i] = 0.0;
        largest = larger(larger(largest, absolute(low)), absolute(high));
        within = within && low <= problem.tension[i] && problem.tension[i] <= high;
    }
    if (r == 0 || within) return clip_to_limits(problem);
    for (int64_t step = 0; step < iterations; step++) {
        project_on_limits(correction);
        nearest_solution(problem, r);
        if (close(largest)) return admitted(problem, r);
    }
    return NOT_FOUND;
}

inline int dykstra(Dykstra& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
