// Controller and tension distribution: a list of compiled operations. SPDX-License-Identifier: Apache-2.0
//
// The controller decides at its start and then once in each control step, independent of the host's steps; its tensions
// or commands are held in between.
#include <string.h>
#include <cdpr/cables/chain.hpp>

#include "outputs.h"

namespace fmu {

static const double DUE = 1e-6;  // share of a control step by which it may be early: the round-off of clocks

bool answered(const Model& model) { return model.report[0] == 0.0; }

static void read(const Model& model, Name first, Name last, double* to) {
    for (int name = first; name <= last; name++) {
        const double* from = model.field[name];
        const size_t size = model.variable[model.owner[from - model.number]].size;
        memcpy(to, from, size * sizeof *to);
        to += size;
    }
}

static bool refuse(const cdpr::Call& call, char* message) {
    if (call.vital == cdpr::ESTIMATE)
        return fails(message, "the estimator failed: check its options, its start and the noise of the sensors");
    if (call.vital == cdpr::FINITE)
        return fails(message, "the controller puts out numbers that are not finite: an input is not, or it diverges");
    return fails(message,
                 "no tensions within the limits were found for what the controller wants, and this FMU ends "
                 "there; exported with solver.infeasible hold_tension or best_effort it continues");
}

// Write the unwound lengths that the controller sees: NaN before the start of the winches.
static void read_winches(const Model& model) {
    const cdpr::WinchStates<double> states = {model.winch, model.places};
    if (!model.has_platform() && model.field[UNSTRETCHED_LENGTH])
        memcpy(model.unwound, model.field[UNSTRETCHED_LENGTH], model.cables * sizeof(double));
    for (size_t i = 0; model.has_platform() && i < model.cables; i++)
        if (model.takes[i] != cdpr::TENSION_COMMAND) model.unwound[i] = states.unwound(int64_t(i));
}

// Start the winches at their first commands, and compute the commands that follow: the last operation, at time 0.
static void start_at_commands(Model& model) {
    start_winches(model);
    read_winches(model);
    size_t last = model.operations;
    while (last > 0 && !model.operation[last - 1].in_order) last--;
    if (last > 0) cdpr::make_calls(model.operation + last - 1, 1, 0.0);
    issue_steps(model, model.wound, model.drive, *model.field[CONTROL_STEP]);
}

// Run the operations of one control step; their time is that since the first one, with the bits of a run.
static bool decide(Model& model, char* message) {
    const double time = *model.decisions * *model.field[CONTROL_STEP];
    read(model, POSITION, ANGULAR_VELOCITY, model.seen);
    read(model, DESIRED_POSITION, DESIRED_ANGULAR_ACCELERATION, model.desired);
    if (model.drive) read_winches(model);
    read_encoders(model);
    const cdpr::Call* failed = cdpr::make_calls(model.operation, model.operations, time);
    if (failed) return refuse(*failed, message);
    if (model.drive) issue_steps(model, model.wound, model.drive, *model.field[CONTROL_STEP]);
    const double* commands = model.drive ? model.wound : model.decided;
    const size_t bytes = model.cables * sizeof *commands;
    memcpy(model.asked(), commands, bytes);
    read_load_cells(model);
    if (model.drive && model.fresh()) start_at_commands(model);
    memcpy(model.asked(), commands, bytes);
    read_arrays(model);
    return true;
}

bool control(Model& model, double time, double duration, char* message) {
    const double end = time + duration, step = *model.field[CONTROL_STEP], early = DUE * step;
    double &decisions = *model.decisions, &began = *model.began;
    if (decisions == 0.0) began = time;
    while (time < end - early || (time < end && duration <= early)) {
        if (!take_loads(model, time, message)) return false;
        if (time >= began + decisions * step - early) {
            if (!decide(model, message)) return false;
            decisions += 1.0;
        }
        const double next = began + decisions * step, until = next < end - early ? next : end;
        if (model.has_platform() && !move(model, time, until - time, message)) return false;
        time = until;
        if (model.has_platform() && time >= next - early) count_steps(model);
    }
    return true;
}

}  // namespace fmu
