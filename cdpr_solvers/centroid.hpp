// Centroid of the admissible tensions, for one or two redundant cables. SPDX-License-Identifier: Apache-2.0
//
// Mikelsons, Bruckmann, Schramm and Hiller (2008); Gouttefarde, Lamaury, Reichert and Bruckmann (2015). See the
// docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr/tension/polygon.hpp>
#include <cdpr/tension/solution.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

struct Centroid {
    TensionProblem<double> problem;
    double* corners;  // (2, 2 m + 4, 2), work space
    static constexpr auto fields = extended(TensionProblem<double>::fields, "work corners(2, 2*m + 4, 2)");

    // Write the centroid x (r); return whether tensions are admissible.
    inline bool write_centre(int64_t r, double* x) const {
        const int64_t room = 2 * problem.m + 4;
        const Polytope<double> set = polytope_of<double>(problem, r, x, nullptr);
        x[0] = 0.0;
        x[1] = 0.0;
        if (r == 0) return true;
        if (r == 1) {
            if (clip_interval(set, x) == 0) return false;
            x[0] = 0.5 * (x[0] + x[1]);
            return true;
        }
        Corners polygon = {corners, 0, room};
        clip_polygon(set, polygon, corners + 2 * room);
        if (polygon.count > 0) centre_of_polygon(polygon, x);
        return polygon.count > 0;
    }

    inline double choose(int64_t r) const {
        if (r > 2) return UNSUPPORTED;
        for (int64_t i = 0; i < problem.m; i++)  // the set may be unbounded, without a centroid
            if (!(problem.tension_max[i] - problem.tension_min[i] < INFINITE)) return UNSUPPORTED;
        double x[2];
        if (!write_centre(r, x)) return INFEASIBLE;
        write_solution(problem, r, x);
        return clip_to_limits(problem);
    }
};

inline int centroid(Centroid& solver) { return distribute(solver); }

}  // namespace cdpr::CDPR_TARGET
