// Solvers in null-space form, for one problem or for eight side by side. SPDX-License-Identifier: Apache-2.0
//
// A rule chooses one of the solutions c + N x: `Rule::choose(problem, r)` writes the tensions and returns their status.
#pragma once

#include <cdpr/alone.hpp>
#include <cdpr/tension/null_space.hpp>

namespace cdpr::CDPR_TARGET {

template <class Rule> inline int distribute(TensionProblem<double>& problem) {
    const int64_t r = reduce(problem);
    const double status = r < 0 ? double(-r) : Rule::choose(problem, r);
    *problem.status = status;
    return int(status);
}

// The same for a solver with its own numbers or work space: its first member is the `problem`, and its member function
// `choose(r)` is the rule.
template <class Solver> inline int distribute(Solver& solver) {
    const int64_t r = reduce_once(solver.problem);
    const double status = r < 0 ? double(-r) : solver.choose(r);
    *solver.problem.status = status;
    return int(status);
}

#ifdef CDPR_LANES
// Solve the problem of one lane alone, in the lanes' work space.
template <class Rule> inline void distribute_alone(TensionProblem<Lanes>& eight, int lane) {
    const int64_t n = eight.n, m = eight.m;
    Space space = {doubles(eight.factors), lane};
    double status = OK;
    double* factors = space.reserve((n + 5) * (n + m));
    TensionProblem<double> one = {space.copied(eight.matrix, n * m),
                                  space.copied(eight.wrench, n),
                                  space.copied(eight.tension_min, m),
                                  space.copied(eight.tension_max, m),
                                  space.copied(eight.tension, m),
                                  &status,
                                  doubles(eight.basis),
                                  doubles(eight.box),
                                  factors,
                                  n,
                                  m};
    distribute<Rule>(one);
    put(one.tension, eight.tension, lane, m);
    eight.status->set(lane, status);
}

// Return the bits of the lanes with a status other than OK.
template <class Rule> CDPR_INLINE int distribute(TensionProblem<Lanes>& problem) {
    const int64_t r = reduce(problem);
    const Mask together = common(problem, r);
    const int found = bits(together);
    if (found != 0) *problem.status = Rule::choose(problem, r);
    for (int lane = 0; lane < WIDTH; lane++)
        if ((found >> lane & 1) == 0) distribute_alone<Rule>(problem, lane);
    return bits(*problem.status != Lanes(double(OK)));
}
#endif

}  // namespace cdpr::CDPR_TARGET
