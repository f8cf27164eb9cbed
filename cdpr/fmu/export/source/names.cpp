// Names of variables. SPDX-License-Identifier: Apache-2.0
#include "model.h"

namespace fmu {

static const char* const ALL[] = {
    "time",
    "physics_step",
    "control_step",
    "cable_tension",
    "cable_length",
    "cable_rate",
    "mass",
    "center_of_mass",
    "inertia",
    "gravity",
    "initial_position",
    "initial_quaternion",
    "initial_velocity",
    "initial_angular_velocity",
    "external_force",
    "external_moment",
    "position",
    "quaternion",
    "velocity",
    "angular_velocity",
    "acceleration",
    "angular_acceleration",
    "unilateral",
    "guide",
    "command",
    "drum_speed",
    "unstretched_length",
    "unstretched_rate",
    "motor_torque",
    "motor_current",
    "motor_voltage",
    "electrical_power",
    "cable_work",
    "bending_force",
    "bending_moment",
    "counted_length",
    "lost_steps",
    "initial_unstretched_length",
    "desired_position",
    "desired_quaternion",
    "desired_velocity",
    "desired_angular_velocity",
    "desired_acceleration",
    "desired_angular_acceleration",
    "load_start",
    "load_end",
    "load_mass",
    "load_center",
    "load_inertia",
    "load_known",
    "fault",
    "fault_time",
};
static_assert(sizeof ALL / sizeof *ALL == NAMES, "one name each");

const char* name_of(Name name) { return ALL[name]; }

}  // namespace fmu
