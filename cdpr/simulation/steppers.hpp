// Step counts of stepper drives, and the steps that they lose. SPDX-License-Identifier: Apache-2.0
//
// Equations: the docstring of `cdpr.cables.stepper`. A drive counts the unwound length to which its steps lead, and
// does not notice lost steps.
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/random_numbers.hpp>

namespace cdpr::CDPR_TARGET {

struct StepDrives {
    const double* chains;   // (m, 33), chain.hpp
    const double* unwound;  // (m), m, of the plant; NaN before its start
    const double* brakes;   // (m), N m, as in Plant: without power, a drive makes no steps
    double* counted;        // (m), m, unwound length to which the steps so far lead
    double* issued;         // (m), m, that at the end of the control period
    double* lost;           // (m), lost full steps, positive if the cable was paid out
    int64_t m;
    static constexpr char fields[] =
        "chains(m, 33), unwound(m), brakes(m), both counted(m), both issued(m), both lost(m), m";

    double kind(int64_t i) const { return chain_row(chains, i).winch_kind(); }
    double radius(int64_t i) const { return chain_row(chains, i).per_turn(unwound[i]); }  // constant for steppers
    StepperNumbers<double> numbers(int64_t i) const {
        return stepper_of(kind(i), chains + i * ChainRow<double>::WIDTH + ChainRow<double>::WINCH);
    }
    bool started(int64_t i) const { return unwound[i] == unwound[i]; }
    bool powered(int64_t i) const { return brakes[i] < 0.0; }
};

// Counts at a sample, before the new steps.
struct StepCounting {
    StepDrives drives;
    const double* torque;  // (m), N m, of the motors about the drums' axes
    static constexpr auto fields = extended(StepDrives::fields, "torque(m)");
};

// Write counted lengths and lost steps. Without inertia, an overloaded motor slips by a period of its torque during the
// coming control period; with inertia, the rotor of the plant has slipped.
inline int count_steps(StepCounting& p) {
    const StepDrives& drives = p.drives;
    for (int64_t i = 0; i < drives.m; i++) {
        const double kind = drives.kind(i), period = StepperNumbers<double>::PERIOD;
        if (!is_stepper(kind) || !drives.started(i)) continue;
        const StepperNumbers<double> numbers = drives.numbers(i);
        drives.counted[i] = drives.issued[i];
        if (!prescribes_speed(kind)) {
            const double slip = (drives.unwound[i] - drives.counted[i]) / drives.radius(i) / numbers.full_step();
            drives.lost[i] = period * rounded(slip / period);
        } else if (drives.powered(i) && absolute(p.torque[i]) > numbers.stall_torque) {
            drives.lost[i] += copy_sign(period, p.torque[i]);
        }
    }
    return 0;
}

// Steps of the coming control period.
struct StepIssue {
    StepDrives drives;
    const double* command;  // (m), m
    double* drive;          // (m), rates for the kernels of the winches, m/s; before their start lengths, m
    double period;          // s, of control
    static constexpr auto fields = extended(StepDrives::fields, "command(m), drive(m), period");
};

// Write the whole steps that lead to the commanded lengths, as far as the speed limit permits, and the rates that the
// plant then has.
inline int issue_steps(StepIssue& p) {
    const StepDrives& drives = p.drives;
    for (int64_t i = 0; i < drives.m; i++) {
        const double kind = drives.kind(i), radius = drives.radius(i);
        if (!is_stepper(kind)) {
            drives.counted[i] = drives.lost[i] = NOT_A_NUMBER;
            continue;
        }
        const StepperNumbers<double> numbers = drives.numbers(i);
        const double target = nearest_multiple(p.command[i], radius * numbers.microstep());
        if (!drives.started(i)) {
            drives.counted[i] = drives.issued[i] = p.drive[i] = target;
            drives.lost[i] = 0.0;
            continue;
        }
        const double from = drives.counted[i], reach = radius * numbers.speed_max * p.period;
        const double aim = drives.powered(i) ? target : from;
        drives.issued[i] = smaller(larger(aim, from - reach), from + reach);
        const double slipped = drives.lost[i] * radius * numbers.full_step();
        const double before = prescribes_speed(kind) ? drives.unwound[i] - slipped : drives.counted[i];
        p.drive[i] = (drives.issued[i] - before) / p.period;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
