// Steps of stepper drives: what they count and lose. SPDX-License-Identifier: Apache-2.0
//
// A control period is that of the controller; without one, a communication step.
#include <math.h>
#include <cdpr/mechanics/winches.hpp>
#include <cdpr/simulation/steppers.hpp>

#include "outputs.h"

namespace fmu {

static const double POWER = -1.0;  // brake torque of a winch with power

bool is_stepper(const Model& model, size_t i) {
    return model.chains && cdpr::is_stepper(cdpr::chain_row(model.chains, int64_t(i)).winch_kind());
}

static bool has_steppers(const Model& model) {
    for (size_t i = 0; model.has_platform() && i < model.cables; i++)
        if (is_stepper(model, i)) return true;
    return false;
}

static cdpr::StepDrives drives_of(const Model& model) {
    const Platform& p = model.platform;
    const double* unwound = model.scratch.unwound;
    return {model.chains, unwound, p.powered, p.counted, p.issued, p.lost, int64_t(model.cables)};
}

double start_of_stepper(const Model& model, size_t i, double length) {
    return drives_of(model).nearest(int64_t(i), length);
}

void issue_steps(Model& model, const double* command, double* drive, double period) {
    if (!has_steppers(model)) return;
    const cdpr::WinchStates<double> states = {model.winch, model.places};
    for (size_t i = 0; i < model.cables; i++) {
        model.platform.powered[i] = POWER;
        model.scratch.unwound[i] = is_stepper(model, i) && !model.fresh() ? states.unwound(int64_t(i)) : NAN;
    }
    cdpr::StepIssue problem = {drives_of(model), command, drive, period};
    cdpr::issue_steps(problem);
}

void count_steps(Model& model) {
    if (!has_steppers(model) || model.fresh()) return;
    const Scratch& s = model.scratch;
    cdpr::Plant<double> plant = plant_of(model);
    apply_inputs(model, true);
    cdpr::settle_winches(plant);
    cdpr::WinchReading reading = {plant, s.unwound, s.unwinding, s.torque};
    cdpr::read_winches(reading);
    cdpr::StepCounting problem = {drives_of(model), s.torque};
    cdpr::count_steps(problem);
    publish(model);
}

}  // namespace fmu
