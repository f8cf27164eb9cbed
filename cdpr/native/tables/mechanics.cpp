// Mechanics: platform, clearances, limits of cables, forward kinematics. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/mechanics/clearance.hpp>
#include <cdpr/mechanics/clearances.hpp>
#include <cdpr/mechanics/curves.hpp>
#include <cdpr/mechanics/distances.hpp>
#include <cdpr/mechanics/energy.hpp>
#include <cdpr/mechanics/equilibrium.hpp>
#include <cdpr/mechanics/forward_kinematics.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/reach.hpp>
#include <cdpr/mechanics/sag.hpp>
#include <cdpr/mechanics/sagging_clearance.hpp>
#include <cdpr/mechanics/stiffness.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<InverseDynamics<double>, static_cast<int (*)(InverseDynamics<double>&)>(inverse_dynamics)>(
        "inverse_dynamics"),
    entry<PlatformEnergy<double>, platform_energy<double>>("energy"),
    entry<SegmentDistances, segment_distances>("segment_distances"),
    entry<SolidDistances, solid_distances>("solid_distances"),
    entry<Clearances, clearances>("clearances"),
    entry<TooNear, too_near>("too_near"),
    entry<SaggingClearances, sagging_clearances>("sagging_clearances"),
    entry<SaggingTooNear, sagging_too_near>("sagging_too_near"),
    entry<CableCurves, cable_curves>("cable_curves"),
    entry<BeyondLimits, beyond_limits>("beyond_limits"),
    entry<LimitViolations, limit_violations>("limit_violations"),
    entry<ForwardKinematics, forward_kinematics>("forward_kinematics"),
    entry<ExternalWork<double>, static_cast<int (*)(ExternalWork<double>&)>(external_work)>("external_work"),
    entry<Stiffness, static_cast<int (*)(Stiffness&)>(stiffness)>("stiffness"),
    entry<SaggingStiffness, sagging_stiffness>("sagging_stiffness"),
    entry<SaggingWrench, sagging_wrench>("sagging_wrench"),
    entry<Potential, potential>("potential"),
    entry<RestLengths, rest_lengths>("rest_lengths"),
};

extern const cdpr_group mechanics = group(entries);

}  // namespace cdpr::CDPR_TARGET
