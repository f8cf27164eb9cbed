// Winches and cables without the platform: lengths and rates are inputs. SPDX-License-Identifier: Apache-2.0
#include <string.h>
#include <cdpr/cables/chain.hpp>
#include <cdpr/scheme.hpp>

#include "model.h"

namespace fmu {

// Before the first step the winches have no state.
static bool fresh(const Model& model) { return model.states > 0 && model.winch[0] != model.winch[0]; }

static cdpr::WinchStates<double> states_at(const Model& model, double* numbers) { return {numbers, model.places}; }

// Commands of the cables; negative ones count as 0 for cables that cannot push.
static const double* commands(const Model& model) {
    for (size_t i = 0; i < model.cables; i++) {
        const double asked = model.field[COMMAND][i];
        model.platform.command[i] = model.immediate(i) && asked < model.lowest() ? 0.0 : asked;
    }
    return model.platform.command;
}

static void begin(const Model& model) {
    cdpr::ChainStart<double> start = {model.chains,
                                      commands(model),
                                      model.field[CABLE_LENGTH],
                                      model.field[CABLE_RATE],
                                      states_at(model, model.winch),
                                      int64_t(model.cables)};
    cdpr::chain_start(start);
}

// Write the tensions at a state of the winches.
static void pull(const Model& model, double* winch) {
    const Scratch& scratch = model.scratch;  // `light`, 0 here: without the platform no length accelerates
    memset(scratch.light, 0, model.cables * sizeof *scratch.light);
    cdpr::ChainTensions<double> cables = {
        model.chains,         commands(model),         model.field[CABLE_LENGTH],  model.field[CABLE_RATE],
        scratch.light,        states_at(model, winch), model.field[CABLE_TENSION], scratch.mass,
        int64_t(model.cables)};
    cdpr::chain_tensions(cables);
}

static void write_slope(const Model& model, double* winch, double* slope) {
    pull(model, winch);
    cdpr::ChainSlopes<double> slopes = {model.chains,
                                        model.platform.command,
                                        model.field[CABLE_TENSION],
                                        model.field[CABLE_LENGTH],
                                        model.field[CABLE_RATE],
                                        states_at(model, winch),
                                        states_at(model, slope),
                                        int64_t(model.cables)};
    cdpr::chain_slopes(slopes);
}

static void step_once(Model& model, double step) {
    const size_t n = model.states;
    double *point = model.scratch.points, *slope = point + n, *sum = slope + n;
    memcpy(point, model.winch, n * sizeof *point);
    memset(sum, 0, n * sizeof *sum);
    for (int stage = 0; stage < cdpr::STAGES; stage++) {
        write_slope(model, point, slope);
        for (size_t i = 0; i < n; i++) {
            sum[i] += cdpr::weight(stage) * slope[i];
            point[i] = model.winch[i] + cdpr::reach(stage, step) * slope[i];
        }
    }
    for (size_t i = 0; i < n; i++) model.winch[i] += step / 6.0 * sum[i];
}

void advance_actuator(Model& model, double step, double steps) {
    if (fresh(model)) begin(model);
    for (double i = 0.0; i < steps; i += 1.0) step_once(model, step);
}

void publish_actuator(Model& model) {
    const size_t m = model.cables;
    const bool before = fresh(model);  // the outputs are then those at the start
    const cdpr::WinchStates<double> states = states_at(model, model.winch);
    if (before) begin(model);
    pull(model, model.winch);
    for (size_t i = 0; i < m; i++) {
        const cdpr::ChainRow<double> row = cdpr::chain_row(model.chains, int64_t(i));
        const double turn = row.per_turn(model.field[CABLE_LENGTH][i]);
        const double carried = turn != 0.0 ? -model.field[CABLE_RATE][i] / turn : 0.0;
        model.field[DRUM_SPEED][i] = row.stretches() ? states.speed(int64_t(i)) : carried;
        if (model.field[UNSTRETCHED_LENGTH])
            model.field[UNSTRETCHED_LENGTH][i] =
                row.stretches() ? states.unwound(int64_t(i)) : model.field[CABLE_LENGTH][i];
    }
    for (size_t i = 0; before && i < model.states; i++) model.winch[i] = cdpr::NOT_A_NUMBER;
}

}  // namespace fmu
