// Simulation: operations of the loop. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/simulation/drives.hpp>
#include <cdpr/simulation/estimation.hpp>
#include <cdpr/simulation/loads.hpp>
#include <cdpr/simulation/observe.hpp>
#include <cdpr/simulation/small_operations.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Observation<double>, observe<double>>("observe"),
    entry<Geometry<double>, observe_nominal<double>>("observe_nominal"),
    entry<Exertion<double>, exert<double>>("exert"),
    entry<BentExertion<double>, exert_bent<double>>("exert_bent"),
    entry<ImperfectDrives, apply_drives>("apply_drives"),
    entry<Arrival<double>, arrived<double>>("arrived"),
    entry<EstimateStart<double>, start_estimate<double>>("start_estimate"),
    entry<EstimateError<double>, judge_estimate<double>>("judge_estimate"),
    entry<EstimatedAttitude<double>, not_unit<double>>("not_unit"),
    entry<ExternalLoads, external_loads>("external_loads"),
    entry<Copy<double>, copy<double>>("copy"),
    entry<Stamp, stamp>("stamp"),
    entry<Values<double>, not_finite<double>>("not_finite"),
    entry<GivenCommand, record_command>("record_command"),
    entry<SampleTime, later_sample>("later_sample"),
    entry<Clock, clock_differs>("clock_differs"),
    entry<PowerOff<double>, power_off<double>>("power_off"),
#ifndef CDPR_ALONE
    entry<Observation<Lanes>, observe<Lanes>>("observe_lanes"),
    entry<Geometry<Lanes>, observe_nominal<Lanes>>("observe_nominal_lanes"),
    entry<Exertion<Lanes>, exert<Lanes>>("exert_lanes"),
    entry<BentExertion<Lanes>, exert_bent<Lanes>>("exert_bent_lanes"),
    entry<Arrival<Lanes>, arrived<Lanes>>("arrived_lanes"),
    entry<EstimateStart<Lanes>, start_estimate<Lanes>>("start_estimate_lanes"),
    entry<EstimateError<Lanes>, judge_estimate<Lanes>>("judge_estimate_lanes"),
    entry<EstimatedAttitude<Lanes>, not_unit<Lanes>>("not_unit_lanes"),
    entry<Copy<Lanes>, copy<Lanes>>("copy_lanes"),
    entry<Values<Lanes>, not_finite<Lanes>>("not_finite_lanes"),
    entry<PowerOff<Lanes>, power_off<Lanes>>("power_off_lanes"),
#endif
};

extern const cdpr_group simulation = group(entries);

}  // namespace cdpr::CDPR_TARGET
