// Tension distribution: what solvers share, checks and policies. SPDX-License-Identifier: Apache-2.0
#include <cdpr/checks.hpp>
#include <cdpr/group.hpp>
#include <cdpr/policy.hpp>
#include <cdpr/polygons.hpp>
#include <cdpr/polytope_points.hpp>
#include <cdpr/safest.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Acceptance<double>, accept<double>>("accept"),
    entry<Acceptance<Lanes>, accept<Lanes>>("accept_lanes"),
    entry<NearestPoint, nearest_point>("nearest_point"),
    entry<ExtremePoint, extreme_point>("extreme_point"),
    entry<NearestByRows, nearest_tension_by_rows>("nearest_by_rows"),
    entry<BoxLeastSquares, box_least_squares>("box_least_squares"),
    entry<Fallback, replace_tension>("replace_tension"),
    entry<AdmissibleCorners<1>, admissible_interval>("admissible_interval"),
    entry<AdmissibleCorners<2>, admissible_polygon>("admissible_polygon"),
    entry<SafestPoint, safest_points>("safest_point"),
};

extern const cdpr_group tension = group(entries);

}  // namespace CDPR_TARGET
}  // namespace cdpr
