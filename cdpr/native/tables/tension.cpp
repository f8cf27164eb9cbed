// Tension distribution: shared operations, checks, policies and many rows. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/tension/checks.hpp>
#include <cdpr/tension/command.hpp>
#include <cdpr/tension/distribute_rows.hpp>
#include <cdpr/tension/imposed.hpp>
#include <cdpr/tension/null_space_form.hpp>
#include <cdpr/tension/policy.hpp>
#include <cdpr/tension/polygons.hpp>
#include <cdpr/tension/polytope_points.hpp>
#include <cdpr/tension/safest.hpp>
#include <cdpr/tension/select_rows.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Acceptance<double>, accept<double>>("accept"),
    entry<Selection<double>, select_rows<double>>("select_rows"),
    entry<Imposed<double>, impose_tensions<double>>("impose_tensions"),
    entry<Room<double>, room_within_limits<double>>("room_within_limits"),
    entry<Command, take_command>("take_command"),
    entry<ImposedCommand<double>, impose_command<double>>("impose_command"),
    entry<NullSpaceForm, null_space_form>("null_space_form"),
    entry<NearestPoint, nearest_point>("nearest_point"),
    entry<ExtremePoint, extreme_point>("extreme_point"),
    entry<NearestByRows, nearest_tension_by_rows>("nearest_by_rows"),
    entry<BoxLeastSquares, box_least_squares>("box_least_squares"),
    entry<Fallback, replace_tension>("replace_tension"),
    entry<AdmissibleCorners<1>, admissible_interval>("admissible_interval"),
    entry<AdmissibleCorners<2>, admissible_polygon>("admissible_polygon"),
    entry<SafestPoint, safest_points>("safest_point"),
    entry<DistributedRows, distribute_rows>("distribute_rows"),
#ifndef CDPR_ALONE
    entry<Acceptance<Lanes>, accept<Lanes>>("accept_lanes"),
    entry<Selection<Lanes>, select_rows<Lanes>>("select_rows_lanes"),
    entry<Imposed<Lanes>, impose_tensions<Lanes>>("impose_tensions_lanes"),
    entry<Room<Lanes>, room_within_limits<Lanes>>("room_within_limits_lanes"),
    entry<ImposedCommand<Lanes>, impose_command<Lanes>>("impose_command_lanes"),
    entry<RowsSideBySide, distribute_rows_side_by_side>("distribute_rows_lanes"),
#endif
};

extern const cdpr_group tension = group(entries);

}  // namespace cdpr::CDPR_TARGET
