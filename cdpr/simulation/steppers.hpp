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

    double kind(int64_t i) const { return row(i).winch_kind(); }
    ChainRow<double> row(int64_t i) const { return chain_row(chains, i); }
    StepperNumbers<double> numbers(int64_t i) const {
        return stepper_of(kind(i), chains + i * ChainRow<double>::WIDTH + ChainRow<double>::WINCH);
    }
    // Return the angle, rad, by which the drum winds in from an unwound length to another, m.
    double turned(int64_t i, double from, double to) const {
        return Transmission::turned(row(i).transmission(), row(i).per_turn(from), from, to);
    }
    // Return the mean length per angle, m/rad, while it winds in by an angle, rad, from an unwound length, m.
    double per_turn(int64_t i, double from, double angle) const {
        return Transmission::mean_per_turn(row(i).transmission(), row(i).per_turn(from), angle);
    }
    // Return the unwound length, m, at a whole number of microsteps that is closest to a length: counted from a cable
    // of length 0, or on a drum that grows, from the home pose.
    double nearest(int64_t i, double length) const {
        const double microstep = numbers(i).microstep(), *line = row(i).transmission();
        if (line[Transmission::GROWTH] == 0.0) {
            const double step = row(i).per_turn(length) * microstep;
            return whole(length / step) * step;
        }
        const double steps = whole(row(i).angle(length) / microstep);
        return Transmission::unwound_at(line, row(i).row[ChainRow<double>::WINCH], steps * microstep);
    }
    static double whole(double steps) { return absolute(steps) < MANY ? rounded(steps) : steps; }

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
            const double slip = drives.turned(i, drives.unwound[i], drives.counted[i]) / numbers.full_step();
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
        const double kind = drives.kind(i);
        if (!is_stepper(kind)) {
            drives.counted[i] = drives.lost[i] = NOT_A_NUMBER;
            continue;
        }
        const StepperNumbers<double> numbers = drives.numbers(i);
        const double target = drives.nearest(i, p.command[i]);
        if (!drives.started(i)) {
            drives.counted[i] = drives.issued[i] = p.drive[i] = target;
            drives.lost[i] = 0.0;
            continue;
        }
        const double from = drives.counted[i], aim = drives.powered(i) ? target : from;
        drives.issued[i] = aim;
        if (finite(numbers.speed_max)) {
            const double most = numbers.speed_max * p.period;
            const double in = drives.per_turn(i, from, most) * numbers.speed_max * p.period;
            const double out = drives.per_turn(i, from, -most) * numbers.speed_max * p.period;
            drives.issued[i] = smaller(larger(aim, from - in), from + out);
        }
        const double away = drives.lost[i] * numbers.full_step();
        const double slipped = drives.lost[i] * drives.per_turn(i, drives.issued[i], -away) * numbers.full_step();
        const double before = prescribes_speed(kind) ? drives.unwound[i] - slipped : drives.counted[i];
        p.drive[i] = (drives.issued[i] - before) / p.period;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
