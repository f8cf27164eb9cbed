// Sensors. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/sensing/encoders.hpp>
#include <cdpr/sensing/imu.hpp>
#include <cdpr/sensing/markers.hpp>
#include <cdpr/sensing/measurement.hpp>
#include <cdpr/sensing/rays.hpp>
#include <cdpr/sensing/receiver.hpp>
#include <cdpr/sensing/tension.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Markers, project_markers>("project_markers"),
    entry<Measurement<double>, measure<double>>("measure"),
    entry<InertialMotion, inertial_motion>("inertial_motion"),
    entry<PaidOut, paid_out>("paid_out"),
    entry<LastTensions, last_tensions>("last_tensions"),
    entry<PointOnPlatform, point_on_platform>("point_on_platform"),
    entry<Rays, cast_rays>("cast_rays"),
#ifndef CDPR_ALONE
    entry<Measurement<Lanes>, measure<Lanes>>("measure_lanes"),
#endif
};

extern const cdpr_group sensing = group(entries);

}  // namespace cdpr::CDPR_TARGET
