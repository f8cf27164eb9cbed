// Controllers. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr_controllers/adaptive.hpp>
#include <cdpr_controllers/cable_length.hpp>
#include <cdpr_controllers/computed_torque.hpp>
#include <cdpr_controllers/estimators/complementary.hpp>
#include <cdpr_controllers/estimators/ekf.hpp>
#include <cdpr_controllers/estimators/forward_kinematics.hpp>
#include <cdpr_controllers/estimators/length_fit.hpp>
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
    entry<KalmanFilter<double>, kalman_filter<double>>("kalman_filter"),
    entry<ArrivingMeasurement<double>, take_measurement<double>>("take_measurement"),
    entry<VisualServo, visual_servo>("visual_servo"),
    entry<LengthFit, fit_lengths>("fit_lengths"),
    entry<PoseDifferences, pose_differences>("pose_differences"),
    entry<ComplementaryFilter, complementary_filter>("complementary_filter"),
#ifndef CDPR_ALONE
    entry<TaskSpaceControl<Lanes>, computed_torque<Lanes>>("computed_torque_lanes"),
    entry<TaskSpaceControl<Lanes>, static_control<Lanes>>("static_lanes"),
    entry<PidControl<Lanes>, pid<Lanes>>("pid_lanes"),
    entry<SlidingModeControl<Lanes>, sliding_mode<Lanes>>("sliding_mode_lanes"),
    entry<AdaptiveControl<Lanes>, adaptive<Lanes>>("adaptive_lanes"),
    entry<KalmanFilter<Lanes>, kalman_filter<Lanes>>("kalman_filter_lanes"),
    entry<ArrivingMeasurement<Lanes>, take_measurement<Lanes>>("take_measurement_lanes"),
#endif
};

extern const cdpr_group controllers = group(entries);

}  // namespace cdpr::CDPR_TARGET
