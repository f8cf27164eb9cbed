// Controllers. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr_controllers/adaptive.hpp>
#include <cdpr_controllers/cable_length.hpp>
#include <cdpr_controllers/computed_torque.hpp>
#include <cdpr_controllers/inverse_kinematics.hpp>
#include <cdpr_controllers/pid.hpp>
#include <cdpr_controllers/sliding_mode.hpp>
#include <cdpr_controllers/static.hpp>
#include <cdpr_controllers/tension_feedback.hpp>
#include <cdpr_controllers/visual_servo.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<TaskSpaceControl<double>, computed_torque<double>>("computed_torque"),
    entry<TaskSpaceControl<double>, static_control<double>>("static"),
    entry<PidControl<double>, pid<double>>("pid"),
    entry<SlidingModeControl<double>, sliding_mode<double>>("sliding_mode"),
    entry<AdaptiveControl<double>, adaptive<double>>("adaptive"),
    entry<TensionFeedback, tension_feedback>("tension_feedback"),
    entry<CableLengthControl, cable_length>("cable_length"),
    entry<InverseKinematics, inverse_kinematics>("inverse_kinematics"),
    entry<VisualServo, visual_servo>("visual_servo"),
#ifndef CDPR_ALONE
    entry<TaskSpaceControl<Lanes>, computed_torque<Lanes>>("computed_torque_lanes"),
    entry<TaskSpaceControl<Lanes>, static_control<Lanes>>("static_lanes"),
    entry<PidControl<Lanes>, pid<Lanes>>("pid_lanes"),
    entry<SlidingModeControl<Lanes>, sliding_mode<Lanes>>("sliding_mode_lanes"),
    entry<AdaptiveControl<Lanes>, adaptive<Lanes>>("adaptive_lanes"),
#endif
};

extern const cdpr_group controllers = group(entries);

}  // namespace cdpr::CDPR_TARGET
