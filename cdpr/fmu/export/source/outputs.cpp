// Outputs of a platform. SPDX-License-Identifier: Apache-2.0
#include "outputs.h"

#include <string.h>
#include <cdpr/cables/motor.hpp>
#include <cdpr/mechanics/winches.hpp>

namespace fmu {

static void copy(double* to, const double* from, size_t count) { memcpy(to, from, count * sizeof *to); }

// Return cables on winches with the tensions of the applied commands, in scratch space: the state is unchanged. Before
// the first step these are the tensions at the start of the winches.
static cdpr::Plant<double> evaluate_winches(const Model& model) {
    const Platform& p = model.platform;
    const Scratch& s = model.scratch;
    copy(s.body, p.body, 13);
    copy(s.winch, p.winch, model.states);
    copy(s.beside, p.beside, 6);
    copy(s.place, p.place, 7);
    cdpr::Plant<double> ahead = plant_of(model);
    ahead.body = s.body;
    ahead.winch = s.winch;
    ahead.tension = s.tension;
    ahead.highest = s.highest;
    ahead.length = s.length;
    ahead.cable_work = s.cable_work;
    ahead.beside = s.beside;
    ahead.place = s.place;
    place_cables(ahead, cdpr::RestingAnchors());
    cdpr::PlatformDynamics<double> dynamics;
    write_tensions(ahead, dynamics);
    return ahead;
}

// Write the outputs of cables on winches. Return in `bending` (6) the wrench of cables that sag besides W t.
static void publish_winches(Model& model, double* bending) {
    const size_t m = model.cables;
    const Platform& p = model.platform;
    const Scratch& s = model.scratch;
    const cdpr::Plant<double> ahead = evaluate_winches(model);
    copy(model.field[CABLE_TENSION], s.tension, m);
    cdpr::BentReadings<double> bent = {ahead, s.mass, bending};
    read_bent_cables(bent);
    for (size_t i = 0; i < m; i++) {
        const cdpr::ChainRow<double> row = ahead.chain(int64_t(i));
        double present[cdpr::ChainRow<double>::NUMBERS];
        const double turn = row.per_turn(row.stretches() ? ahead.unwound(int64_t(i)) : s.length[i]);
        if (model.field[DRUM_SPEED]) model.field[DRUM_SPEED][i] = ahead.winch_speed(int64_t(i));
        if (model.field[UNSTRETCHED_LENGTH])
            model.field[UNSTRETCHED_LENGTH][i] = row.stretches() ? ahead.unwound(int64_t(i)) : s.length[i];
        if (model.field[UNSTRETCHED_RATE])
            model.field[UNSTRETCHED_RATE][i] = row.stretches() ? -turn * ahead.speed(int64_t(i)) : ahead.rate[i];
        if (model.field[MOTOR_TORQUE])
            model.field[MOTOR_TORQUE][i] =
                motor_torque(row.winch_kind(), ahead.motion(int64_t(i), ahead.tension_at_winch(int64_t(i)), present));
    }
    if (model.motors) {
        cdpr::MotorReading reading = {model.motors,
                                      model.field[MOTOR_TORQUE],
                                      model.field[DRUM_SPEED],
                                      model.field[MOTOR_CURRENT],
                                      model.field[MOTOR_VOLTAGE],
                                      model.field[ELECTRICAL_POWER],
                                      1,
                                      int64_t(m)};
        cdpr::read_motors(reading);
    }
    for (size_t i = 0; i < m; i++) {
        const bool counts = is_stepper(model, i) && !model.fresh();
        if (model.field[COUNTED_LENGTH]) model.field[COUNTED_LENGTH][i] = counts ? p.counted[i] : 0.0;
        if (model.field[LOST_STEPS]) model.field[LOST_STEPS][i] = counts ? p.lost[i] : 0.0;
    }
    if (model.field[CABLE_WORK]) *model.field[CABLE_WORK] = p.cable_work[0];
    if (model.field[BENDING_FORCE]) copy(model.field[BENDING_FORCE], bending, 3);
    if (model.field[BENDING_MOMENT]) copy(model.field[BENDING_MOMENT], bending + 3, 3);
}

void read_encoders(Model& model) {
    if (!model.paid_out) return;
    cdpr::WinchReading reading = {plant_of(model), model.paid_out, model.paid_out + model.cables, model.scratch.torque};
    cdpr::read_winches(reading);
}

void read_load_cells(Model& model) {
    if (!model.pulls) return;
    const size_t m = model.cables;
    apply_inputs(model, true);
    const cdpr::Plant<double> plant = evaluate_winches(model);
    copy(model.pulls, plant.tension, m);
    for (size_t i = 0; i < m; i++) model.pulls[m + i] = plant.tension_at_winch(int64_t(i));
}

void publish_platform(Model& model) {
    const size_t m = model.cables;
    const Platform& p = model.platform;
    const double* state = p.state;
    copy(model.field[POSITION], state, 3);
    copy(model.field[QUATERNION], state + 3, 4);
    copy(model.field[VELOCITY], state + 7, 3);
    copy(model.field[ANGULAR_VELOCITY], state + 10, 3);
    double bending[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    if (model.has_winches()) publish_winches(model, bending);
    const double still[7] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
    double acceleration[6];
    copy(model.scratch.body, state, 13);
    copy(model.scratch.tension, model.has_winches() ? model.field[CABLE_TENSION] : p.command, m);
    cdpr::Plant<double> plant = plant_of(model);
    plant.lines = model.lines;
    plant.offset = still;
    plant.inertial = p.total;
    plant.body = model.scratch.body;
    plant.tension = model.scratch.tension;
    plant.length = model.field[CABLE_LENGTH];
    plant.rate = model.field[CABLE_RATE];
    plant.beside = bending;
    observe(plant, acceleration);
    copy(model.field[ACCELERATION], acceleration, 3);
    copy(model.field[ANGULAR_ACCELERATION], acceleration + 3, 3);
}

}  // namespace fmu
