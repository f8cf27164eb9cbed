// Estimators. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr_controllers/estimators/complementary.hpp>
#include <cdpr_controllers/estimators/ekf.hpp>
#include <cdpr_controllers/estimators/forward_kinematics.hpp>
#include <cdpr_controllers/estimators/length_fit.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<KalmanFilter<double>, kalman_filter<double>>("kalman_filter"),
    entry<ArrivingMeasurement<double>, take_measurement<double>>("take_measurement"),
    entry<LengthFit, fit_lengths>("fit_lengths"),
    entry<PoseDifferences, pose_differences>("pose_differences"),
    entry<ComplementaryFilter, complementary_filter>("complementary_filter"),
#ifndef CDPR_ALONE
    entry<KalmanFilter<Lanes>, kalman_filter<Lanes>>("kalman_filter_lanes"),
    entry<ArrivingMeasurement<Lanes>, take_measurement<Lanes>>("take_measurement_lanes"),
#endif
};

extern const cdpr_group estimators = group(entries);

}  // namespace cdpr::CDPR_TARGET
