// Check of a configuration that was read: kinds of parts, and arrays and variables by name.
// SPDX-License-Identifier: Apache-2.0
#include <string.h>
#include <cdpr/cables/motor.hpp>
#include <cdpr/mechanics/plant.hpp>

#include "model.h"

namespace fmu {

static double* find_array(const Model& model, const char* name, size_t size) {
    for (size_t i = 0; i < model.arrays; i++)
        if (strcmp(model.array[i].name, name) == 0 && model.array[i].size == size) return model.array[i].data;
    return nullptr;
}

// Write the kind of a part; return whether it is valid.
static bool read_kind(double kind, int64_t& to) {
    const bool sound = kind >= 0.0 && kind <= 1000.0 && kind == double(int(kind));
    to = sound ? int64_t(kind) : 0;
    return sound;
}

static bool read_kinds(const Model& model) {
    bool sound = true;
    for (size_t i = 0; i < model.cables; i++) {
        int64_t* kinds = model.kinds + 3 * i;
        if (model.chains) sound = read_kind(model.chains[size_t(cdpr::ChainRow<double>::WIDTH) * i], kinds[0]) && sound;
        if (model.chains)
            sound = read_kind(model.chains[size_t(cdpr::ChainRow<double>::WIDTH) * i + 1], kinds[1]) && sound;
        if (model.lines && model.width > 6) sound = read_kind(model.lines[model.width * i + 6], kinds[2]) && sound;
    }
    return sound;
}

// Read the places of the winches' states; return whether they are valid.
static bool read_places(const Model& model) {
    const double* stored = find_array(model, "winch_places", model.cables + 1);
    if (!model.chains) return model.states == 0;
    if (!stored) return false;
    memcpy(model.places, stored, (model.cables + 1) * sizeof *model.places);
    bool sound = model.places[0] == 0 && model.places[model.cables] == int64_t(model.states);
    for (size_t i = 0; i < model.cables; i++) {
        const cdpr::ChainRow<double> row = cdpr::chain_row(model.chains, int64_t(i));
        const int64_t count = model.places[i + 1] - model.places[i] - cdpr::span_states(row.span_kind());
        const int64_t least = row.stretches() ? cdpr::WinchStates<double>::COORDINATE : 0;
        sound = sound && count >= least && count <= cdpr::MOST_STATES;
    }
    return sound;
}

// Read the quantities that the winches take; return whether they are valid.
static bool read_commands(const Model& model) {
    const double* stored = find_array(model, "takes", model.cables);
    if (!stored) return true;  // tensions
    memcpy(model.takes, stored, model.cables * sizeof *model.takes);
    bool sound = true, others = false;
    for (size_t i = 0; i < model.cables; i++) {
        const int64_t takes = model.takes[i];
        const bool stretches = model.chains && cdpr::chain_row(model.chains, int64_t(i)).stretches();
        sound = sound && takes >= cdpr::TENSION_COMMAND && takes <= cdpr::RATE_COMMAND;
        sound = sound && (takes == cdpr::TENSION_COMMAND || stretches || !model.has_platform());
        others = others || takes != cdpr::TENSION_COMMAND;
    }
    if (others && model.decides()) return sound && model.unwound && model.wound && model.drive;
    return sound && (!others || !model.has_platform() || model.field[INITIAL_UNSTRETCHED_LENGTH]);
}

bool complete(Model& model, char* message) {
    const size_t m = model.cables;
    model.chains = find_array(model, "chains", size_t(cdpr::ChainRow<double>::WIDTH) * m);
    model.lines = find_array(model, "lines", m * model.width);
    model.motors = find_array(model, "motors", size_t(cdpr::Motor::COUNT) * m);
    model.seen = find_array(model, "state", 13);
    model.desired = find_array(model, "desired", 19);
    model.decided = find_array(model, "tension", m);
    model.report = find_array(model, "report", 4);
    model.unwound = find_array(model, "unwound", m);
    model.wound = find_array(model, "winch_command", m);
    model.drive = find_array(model, "drive", m);
    model.paid_out = find_array(model, "paid_out", 2 * m);
    model.pulls = find_array(model, "pulls", 2 * m);
    model.inertial = find_array(model, "inertial", 13);
    if (model.inertial) memcpy(model.nominal, model.inertial, 13 * sizeof(double));
    if (!read_kinds(model)) return broken(message, "unknown kinds of", "parts of cables");
    if (!read_places(model)) return broken(message, "wrong places of", "states of winches");
    if (!read_commands(model)) return broken(message, "wrong commands of", "winches");
    if (!model.field[TIME] || !model.asked()) return broken(message, "missing", name_of(TIME));
    if ((model.has_platform() || model.decides()) && !model.lines) return broken(message, "missing", "lines");
    if (!model.has_platform() && !model.decides() && !model.chains) return broken(message, "missing", "chains");
    if (!model.has_platform() && model.field[ACCELERATION]) return broken(message, "missing", name_of(MASS));
    if (model.decides() && !(model.seen && model.desired && model.decided && model.report))
        return broken(message, "missing", "arrays of the controller");
    if ((model.paid_out || model.pulls) && !(model.has_platform() && model.has_winches()))
        return broken(message, "missing", "winches of the sensors");
    const struct {
        bool needed;
        Name first, last;
    } groups[] = {{model.has_platform(), MASS, ANGULAR_ACCELERATION},
                  {model.decides(), DESIRED_POSITION, DESIRED_ANGULAR_ACCELERATION},
                  {model.decides(), POSITION, ANGULAR_VELOCITY},
                  {model.field[LOAD_MASS] != nullptr, LOAD_START, LOAD_KNOWN}};
    for (const auto& group : groups)
        for (int i = group.first; group.needed && i <= group.last; i++)
            if (!model.field[i]) return broken(message, "missing", name_of(Name(i)));
    if (model.field[LOAD_MASS] && !model.has_platform()) return broken(message, "missing", name_of(MASS));
    const bool moves = model.has_platform() || model.has_winches();
    if (moves && !(model.field[PHYSICS_STEP] && model.field[CABLE_TENSION] && model.field[CABLE_LENGTH] &&
                   model.field[CABLE_RATE] && model.field[UNILATERAL]))
        return broken(message, "missing", "variables of cables");
    if (!model.has_winches() && model.field[DRUM_SPEED]) return broken(message, "missing", "chains");
    for (int i = MOTOR_CURRENT; model.motors && i <= ELECTRICAL_POWER; i++)
        if (!model.field[i] || !model.field[MOTOR_TORQUE] || !model.field[DRUM_SPEED])
            return broken(message, "missing", name_of(Name(i)));
    if ((model.field[BENDING_FORCE] != nullptr) != (model.field[BENDING_MOMENT] != nullptr))
        return broken(message, "missing", name_of(BENDING_MOMENT));
    return true;
}

}  // namespace fmu
