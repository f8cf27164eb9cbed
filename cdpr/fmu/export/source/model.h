// Model of an exported FMU: its variables, and the arrays computed from them. SPDX-License-Identifier: Apache-2.0
//
// A platform on cables, with winches or without; winches alone; and a controller, with a platform or alone.
// Conventions: SI units, world axes, z up; quaternions w, x, y, z; the external wrench acts at the platform's origin.
#pragma once

#include <cdpr/table.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cdpr/calls.hpp>

namespace fmu {

// Variables that this code uses by name; names.cpp contains the names. Others, such as the parameters of winches and
// the gains of controllers, are only linked to arrays.
enum Name {
    TIME,
    PHYSICS_STEP,
    CONTROL_STEP,
    CABLE_TENSION,
    CABLE_LENGTH,
    CABLE_RATE,
    MASS,
    CENTER_OF_MASS,
    INERTIA,
    GRAVITY,
    INITIAL_POSITION,
    INITIAL_QUATERNION,
    INITIAL_VELOCITY,
    INITIAL_ANGULAR_VELOCITY,
    EXTERNAL_FORCE,
    EXTERNAL_MOMENT,
    POSITION,
    QUATERNION,
    VELOCITY,
    ANGULAR_VELOCITY,
    ACCELERATION,
    ANGULAR_ACCELERATION,
    UNILATERAL,  // 1 if cables only pull
    GUIDE,       // 1 along each free axis (3) and about each (3); of guided platforms
    COMMAND,
    DRUM_SPEED,
    UNSTRETCHED_LENGTH,
    UNSTRETCHED_RATE,
    MOTOR_TORQUE,
    MOTOR_CURRENT,
    MOTOR_VOLTAGE,
    ELECTRICAL_POWER,
    CABLE_WORK,
    BENDING_FORCE,
    BENDING_MOMENT,
    COUNTED_LENGTH,  // of steppers
    LOST_STEPS,
    INITIAL_UNSTRETCHED_LENGTH,  // of cables whose winches take lengths or rates
    DESIRED_POSITION,
    DESIRED_QUATERNION,
    DESIRED_VELOCITY,
    DESIRED_ANGULAR_VELOCITY,
    DESIRED_ACCELERATION,
    DESIRED_ANGULAR_ACCELERATION,
    LOAD_START,  // of bodies attached to the platform
    LOAD_END,
    LOAD_MASS,
    LOAD_CENTER,
    LOAD_INERTIA,
    LOAD_KNOWN,  // 1 if the controller takes them into account
    FAULT,       // only in tests, with CDPR_FAULTS
    FAULT_TIME,
    NAMES
};

enum Role {
    INDEPENDENT,
    PARAMETER,
    FIXED,
    INPUT,
    OUTPUT,
    CONSTANT
};  // a fixed parameter: until the end of initialization

constexpr size_t LABEL = 64;     // largest length of a name, a unit or a token, bytes
constexpr size_t MESSAGE = 256;  // largest length of a message, bytes

struct Variable {
    char name[LABEL], unit[LABEL];
    Role role;
    size_t offset, size;  // among the numbers
};

// Array of numbers that operations read and write, and that links fill.
struct Array {
    char name[LABEL];
    double* data;
    size_t size;
};

// Numbers of variables that are also in an array: outputs are copied from it, others into it.
struct Link {
    size_t from, size;  // reference of the first number, and their count
    size_t array, to;   // array and index of the first number
    bool positive;      // whether each must be greater than 0
    bool per_step;      // whether they are multiplied by the control step
};

// Arrays of a platform for the kernels; names and shapes as in their headers.
struct Platform {
    double *offset, *moments, *inertial, *packed, *free;  // body_frame.hpp, reference.hpp, plant.hpp, spherical.hpp
    double* lines;                                        // (m, w), B_i in the body frame
    double *command, *external;                           // as applied: (m), (6)
    double *body, *momentum, *motion, *state;             // (13), (3), (8), (13)
    double *winch, *tension, *highest, *length, *cable_work, *beside, *place;
    double *rates, *period;  // (m), m/s, of ideal drives that take lengths, and (1), s, their communication step
    double *counted, *issued, *lost, *powered;  // (m) each, of steppers: as in simulation/steppers.hpp
    double *total, *loaded_at;  // (13), mass, centre and inertia with attached bodies, and the time at which these are
};

// Scratch space of a platform.
struct Scratch {
    double *rate, *matrix, *at_winch, *runs, *light, *mass, *pulls, *points, *applied, *chains;
    double *unwound, *unwinding, *torque;                                             // (m) each, readings of winches
    double *body, *winch, *tension, *highest, *length, *cable_work, *beside, *place;  // for stages and trial steps
};

// All numbers of the state are in one array: variables in the order of their value references, then the arrays of
// operations, then those of the platform. A copy of it is a snapshot.
struct Model {
    size_t cables, width, states;                          // m; numbers in a row of `lines`; states of all winches
    size_t variables, scalars, arrays, links, operations;  // counts; scalars are the numbers of variables
    Variable* variable;
    size_t* owner;  // (scalars) index of the variable of each number
    Array* array;
    Link* link;
    cdpr::Call* operation;
    size_t count, work_count;
    double* number;          // (count)
    double* work;            // (work_count), scratch space
    double* field[NAMES];    // into `number`; nullptr for variables that the model does not have
    double *chains, *lines;  // arrays by name: chain.hpp and geometry.hpp
    double* motors;          // likewise: motor.hpp
    double *seen, *desired, *decided,
        *report;  // of a controller: state (13), desired motion (19), tensions (m), report (4)
    double *unwound, *wound,
        *drive;                // of a controller of lengths or rates: as in tension/winding.hpp, (m) each
    double *paid_out, *pulls;  // (2, m) each, of sensors: unwound lengths and their rates; tensions at platform, winch
    double *inertial, *nominal;  // of a controller: mass properties (13), with and without attached bodies
    double *decisions, *began;   // number of decisions, and the time of the first, s
    double* winch;               // (states), of winches alone
    Platform platform;
    Scratch scratch;
    int64_t* kinds;   // (m, 3), of winches, spans and exits, as in `chains` and `lines`
    int64_t* takes;   // (m), a cdpr::CommandKind: the quantity that each winch takes as its command
    int64_t* places;  // (m + 1), of the states of each winch in `winch`, and their number
    double* tangent;  // (2 scalars), of directional derivatives
    double* dual;     // scratch space of these
    char token[LABEL];

    bool has_platform() const { return field[MASS] != nullptr; }
    bool has_winches() const { return chains != nullptr; }
    bool decides() const { return field[CONTROL_STEP] != nullptr; }
    bool guided() const { return field[GUIDE] != nullptr; }
    bool on_ball() const;   // turns about all axes, its origin held
    double lowest() const;  // lowest tension, N: 0, or minus infinity for legs that push

    // Return whether the tension of cable i is its input.
    bool immediate(size_t i) const;

    // Return whether the winches have not started.
    bool fresh() const { return states > 0 && winch[0] != winch[0]; }

    // Input, or decision, of each cable (m).
    double* asked() const { return field[has_winches() || !has_platform() ? COMMAND : CABLE_TENSION]; }
};

const char* name_of(Name name);

// Read the configuration; return false with a message if it cannot be used. Free the model in either case.
bool load(Model& model, FILE* file, char* message);
void free_model(Model& model);

// Format the message and return false; `broken` about a part of the configuration.
bool fails(char* message, const char* format, ...);
bool broken(char* message, const char* what, const char* name);

// Find the arrays that this code uses by name, and check that all variables of the model exist: complete.cpp.
bool complete(Model& model, char* message);

// Check the parameters and put the platform into its initial state; return false with a message if they are invalid.
bool start(Model& model, char* message);

// Apply changed parameters, with unchanged pose and motion; return false with a message as above.
bool retune(Model& model, char* message);

// Return whether pose and twist are finite.
bool sound(const Model& model);

// Compute arrays from the parameters: body.cpp. `fill_arrays` copies linked numbers, `build_body` chooses the frame in
// which the platform is integrated; it returns false for an invalid inertia. `read_arrays` copies linked outputs.
void fill_arrays(Model& model);
void read_arrays(Model& model);
bool build_body(Model& model);

// Write mass, centre and inertia (13) of `own` (13) and the attached bodies, or the known ones: loads.cpp.
void add_loads(const Model& model, const double* own, bool known, double* total);

// Return the number of bodies that are attached at some time: loads.cpp.
size_t attached_bodies(const Model& model);

// Return the index of the first attached body with an impossible mass or inertia, or the number of bodies: body.cpp.
size_t impossible_load(const Model& model, size_t count);

// Attach and remove bodies whose time has come; return false with a message as above.
bool take_loads(Model& model, double time, char* message);

// Advance from `time` on by `duration`, with the bodies attached at each time; return false with a message as above.
bool move(Model& model, double time, double duration, char* message);

// Start the winches, if they have not, at the present commands.
void start_winches(Model& model);

// Command ideal drives to reach their lengths after `duration`, and steppers to make their steps.
void command_drives(Model& model, double duration);

// Steppers, steps.cpp. Return whether winch i is one, and the start of its cable at a length, m, in whole steps.
bool is_stepper(const Model& model, size_t i);
double start_of_stepper(const Model& model, size_t i, double length);

// Write the steps of the coming control period that lead to commanded lengths (m), and the rates that the plant then
// has; before the start of the winches, the lengths at which they start.
void issue_steps(Model& model, const double* command, double* drive, double period);

// Count the steps at the end of a control period.
void count_steps(Model& model);

// Advance by `duration` in steps of physics_step, or slightly shorter ones if that does not divide it.
void advance(Model& model, double duration);

// Write the outputs for the state and the inputs: outputs.cpp.
void publish(Model& model);

// Write the derivatives of the outputs along `seed` (scalars), changes of inputs and, before the first step, of
// parameters, into `slope` (scalars), both by value reference: derivatives.cpp. Only for a platform without winches
// whose outputs are published.
void differentiate(const Model& model, const double* seed, double* slope);
size_t dual_size(const Model& model);

// Winches alone, with given lengths and rates: actuator.cpp.
void advance_actuator(Model& model, double step, double steps);
void publish_actuator(Model& model);

// Return the cable that is required to push though it cannot, counted from 0; the number of cables if there is none.
size_t pushed(const Model& model);

// Let the controller decide whenever it is due from `time` on, and advance the platform by `duration`; return false
// with a message if there is no answer. control.cpp
bool control(Model& model, double time, double duration, char* message);
bool answered(const Model& model);  // Return whether the last required wrench was distributed.

}  // namespace fmu
