// Anchors that move, and the plants with such anchors. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/mechanics/anchors.hpp>
#include <cdpr_backends/reference.hpp>
#include <cdpr_backends/reference_guided.hpp>
#include <cdpr_backends/reference_spherical.hpp>
#include <cdpr_backends/reference_winches.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<PlaceAnchors, place_anchors>("place_anchors"),
    entry<PlaceForStep, place_for_step>("place_for_step"),
    entry<ObservedAnchors, observe_anchors>("observe_anchors"),
    entry<Anchored<ReferenceStep<double>>, anchored<ReferenceStep<double>, reference_step_with, count>>(
        "reference_step_anchored"),
    entry<Anchored<GuidedStep<double>>, anchored<GuidedStep<double>, guided_step_with, count>>("guided_step_anchored"),
    entry<Anchored<SphericalStep<double>>, anchored<SphericalStep<double>, spherical_step_with, count>>(
        "spherical_step_anchored"),
    entry<Anchored<Plant<double>>, anchored<Plant<double>, settle_winches_with, count>>("settle_winches_anchored"),
    entry<Anchored<WinchStep<double>>, anchored<WinchStep<double>, step_winches_with, count_of_plant>>(
        "step_winches_anchored"),
    entry<Anchored<WinchRungeKutta<double>>, anchored<WinchRungeKutta<double>, winch_runge_kutta_with, count_of_plant>>(
        "winch_runge_kutta_anchored"),
};

extern const cdpr_group anchors = group(entries);

}  // namespace cdpr::CDPR_TARGET
