// Plants with winches: tensions, and the steps of their winches. SPDX-License-Identifier: Apache-2.0
#include <cdpr/cables/motor.hpp>
#include <cdpr/group.hpp>
#include <cdpr/mechanics/winches.hpp>
#include <cdpr/simulation/steppers.hpp>
#include <cdpr/tension/winding.hpp>
#include <cdpr_backends/reference_winches.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Plant<double>, settle_winches<double>>("settle_winches"),
    entry<WinchStep<double>, step_winches<double>>("step_winches"),
    entry<BentReadings<double>, read_bent_cables<double>>("read_bent_cables"),
    entry<WinchRungeKutta<double>, winch_runge_kutta<double>>("winch_runge_kutta"),
    entry<WinchReading, read_winches>("read_winches"),
    entry<ExitReading<double>, read_winch_tensions<double>>("read_winch_tensions"),
    entry<DrumReading<double>, read_drums<double>>("read_drums"),
    entry<MotorReading, read_motors>("read_motors"),
    entry<Winding, wind>("wind_commands"),
    entry<AppliedCommands, drive_winches>("drive_winches"),
    entry<WinchCommand, take_winch_command>("take_winch_command"),
    entry<StepCounting, count_steps>("count_steps"),
    entry<StepIssue, issue_steps>("issue_steps"),
#ifndef CDPR_ALONE
    entry<Plant<Lanes>, settle_winches<Lanes>>("settle_winches_lanes"),
    entry<WinchStep<Lanes>, step_winches<Lanes>>("step_winches_lanes"),
    entry<BentReadings<Lanes>, read_bent_cables<Lanes>>("read_bent_cables_lanes"),
    entry<ExitReading<Lanes>, read_winch_tensions<Lanes>>("read_winch_tensions_lanes"),
    entry<DrumReading<Lanes>, read_drums<Lanes>>("read_drums_lanes"),
    entry<WinchRungeKutta<Lanes>, winch_runge_kutta<Lanes>>("winch_runge_kutta_lanes"),
#endif
};

extern const cdpr_group winches = group(entries);

}  // namespace cdpr::CDPR_TARGET
