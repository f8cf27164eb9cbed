// Motion of a platform: the integrators of the backend `reference`. SPDX-License-Identifier: Apache-2.0
#include <math.h>
#include <string.h>
#include <cdpr/mechanics/body_frame.hpp>
#include <cdpr_backends/reference.hpp>
#include <cdpr_backends/reference_guided.hpp>
#include <cdpr_backends/reference_spherical.hpp>
#include <cdpr_backends/reference_winches.hpp>

#include "outputs.h"

namespace fmu {

static const double UNIT = 1e-3;   // allowed deviation of a quaternion's length from 1: typed numbers are rounded
static const double HELD = 1e-9;   // rad, m/s, rad/s along blocked directions that are ignored: round-off
static const double WHOLE = 1e-9;  // share of a duration by which it may miss a multiple of the step: round-off

bool Model::on_ball() const {
    const double* guide = field[GUIDE];
    return guide && guide[3] + guide[4] + guide[5] > 1.0;
}

double Model::lowest() const { return *field[UNILATERAL] != 0.0 ? 0.0 : -INFINITY; }

bool Model::immediate(size_t i) const {
    if (!chains) return true;
    const cdpr::ChainRow<double> row = cdpr::chain_row(chains, int64_t(i));
    return row.winch_kind() == cdpr::DIRECT && !row.stretches();
}

// Return whether the winch takes a length, and its kernel the rate at which it reaches the length: an ideal drive.
static bool converted(const Model& model, size_t i) {
    return model.takes[i] != cdpr::command_of(cdpr::chain_row(model.chains, int64_t(i)).winch_kind());
}

// Return the rate at which such a drive reaches its length in a communication step like the last one.
static double rate_of_drive(const Model& model, size_t i) {
    const cdpr::WinchStates<double> states = {model.winch, model.places};
    return (model.asked()[i] - states.unwound(int64_t(i))) / *model.platform.period;
}

// Return the command of cable i for its kernel: no negative one for an immediate cable. The first command of a winch
// that takes lengths or rates is its length at the start. During a step (`moving`) ideal drives have constant rates.
static double applied_command(const Model& model, size_t i, bool moving) {
    const double asked = model.asked()[i];
    if (model.takes[i] == cdpr::TENSION_COMMAND) return model.immediate(i) && asked < model.lowest() ? 0.0 : asked;
    if (model.drive) return model.drive[i];
    if (model.fresh()) {
        const double start = model.field[INITIAL_UNSTRETCHED_LENGTH][i];
        return is_stepper(model, i) ? start_of_stepper(model, i, start) : start;
    }
    if (!converted(model, i)) return asked;
    return moving || is_stepper(model, i) ? model.platform.rates[i] : rate_of_drive(model, i);
}

void apply_inputs(const Model& model, bool moving) {
    for (size_t i = 0; i < model.cables; i++) model.platform.command[i] = applied_command(model, i, moving);
    memcpy(model.platform.external, model.field[EXTERNAL_FORCE], 3 * sizeof(double));
    memcpy(model.platform.external + 3, model.field[EXTERNAL_MOMENT], 3 * sizeof(double));
}

cdpr::Plant<double> plant_of(const Model& model) {
    const Platform& p = model.platform;
    const Scratch& s = model.scratch;
    const double* chains = model.chains ? model.chains : s.chains;
    return {chains,
            p.lines,
            p.offset,
            p.inertial,
            p.free,
            model.field[GRAVITY],
            p.command,
            p.external,
            p.body,
            p.winch,
            p.tension,
            p.highest,
            p.length,
            p.cable_work,
            p.beside,
            p.place,
            s.applied,
            s.rate,
            s.matrix,
            s.at_winch,
            s.runs,
            s.light,
            s.mass,
            s.pulls,
            model.kinds,
            model.places,
            int64_t(model.cables),
            int64_t(model.width),
            int64_t(model.states)};
}

void start_winches(Model& model) {
    if (!model.fresh()) return;
    if (!model.drive) issue_steps(model, model.field[INITIAL_UNSTRETCHED_LENGTH], model.platform.rates, 1.0);
    apply_inputs(model, false);
    cdpr::Plant<double> plant = plant_of(model);
    cdpr::settle_winches(plant);
}

void command_drives(Model& model, double duration) {
    *model.platform.period = duration;
    for (size_t i = 0; model.has_platform() && i < model.cables; i++) {
        if (model.takes[i] == cdpr::TENSION_COMMAND) continue;
        start_winches(model);
        if (converted(model, i)) model.platform.rates[i] = rate_of_drive(model, i);
    }
    issue_steps(model, model.asked(), model.platform.rates, duration);
}

static void step_winches(Model& model, double step, int64_t steps) {
    cdpr::WinchRungeKutta<double> problem = {plant_of(model), model.platform.state, model.scratch.points, step, steps};
    cdpr::winch_runge_kutta(problem);
}

static void step_guided(Model& model, double step, int64_t steps) {
    const Platform& p = model.platform;
    cdpr::GuidedStep<double> problem = {
        p.free,  p.lines, p.inertial, model.field[GRAVITY],  p.command,           p.external, p.motion,
        p.state, step,    steps,      int64_t(model.cables), int64_t(model.width)};
    cdpr::guided_step(problem);
}

static void step_on_ball(Model& model, double step, int64_t steps) {
    const Platform& p = model.platform;
    cdpr::SphericalStep<double> problem = {
        p.lines, p.packed, model.field[GRAVITY],  p.command,           p.external, p.momentum, p.state,
        step,    steps,    int64_t(model.cables), int64_t(model.width)};
    cdpr::spherical_step(problem);
}

static void step_free(Model& model, double step, int64_t steps) {
    const Platform& p = model.platform;
    cdpr::ReferenceStep<double> problem = {
        p.lines, p.offset, p.moments, model.field[GRAVITY],  p.command,           p.external, p.body, p.momentum,
        p.state, step,     steps,     int64_t(model.cables), int64_t(model.width)};
    cdpr::reference_step(problem);
}

void advance(Model& model, double duration) {
    const double h = *model.field[PHYSICS_STEP];
    double n = floor(duration / h + 0.5);
    const bool whole = n >= 1.0 && fabs(duration - n * h) <= WHOLE * duration;
    if (!whole) n = ceil(duration / h);
    const double step = whole ? h : duration / n;
    const int64_t steps = int64_t(n);
    if (!model.has_platform()) {
        advance_actuator(model, step, n);
    } else {
        apply_inputs(model, true);
        if (model.has_winches())
            step_winches(model, step, steps);
        else if (model.on_ball())
            step_on_ball(model, step, steps);
        else if (model.guided())
            step_guided(model, step, steps);
        else
            step_free(model, step, steps);
    }
    publish(model);
}

void publish(Model& model) {
    if (model.has_platform()) {
        apply_inputs(model, false);
        publish_platform(model);
    } else if (model.has_winches()) {
        publish_actuator(model);
    }
}

size_t pushed(const Model& model) {
    size_t i = 0;
    if (model.lowest() < 0.0 || model.decides()) return model.cables;
    while (i < model.cables && !(model.immediate(i) && model.asked()[i] < 0.0)) i++;
    return i;
}

bool sound(const Model& model) {
    double sum = 0.0;
    for (size_t i = 0; model.has_platform() && i < 13; i++) sum += 0.0 * model.platform.state[i];
    for (size_t i = 0; model.has_winches() && i < model.states; i++)
        if (model.winch[0] == model.winch[0]) sum += 0.0 * model.winch[i];
    return sum == 0.0;
}

static bool check(const Model& model, char* message) {
    for (size_t i = 0; i < model.scalars; i++) {
        const Variable& variable = model.variable[model.owner[i]];
        if ((variable.role == PARAMETER || variable.role == FIXED) && !isfinite(model.number[i]))
            return fails(message, "%s is not finite", variable.name);
    }
    const Name positive[] = {MASS, PHYSICS_STEP, CONTROL_STEP};
    for (const Name name : positive)
        if (model.field[name] && !(*model.field[name] > 0.0))
            return fails(message, "%s must be greater than 0 (%s)", name_of(name), name == MASS ? "kg" : "s");
    const size_t bodies = attached_bodies(model), wrong = bodies ? impossible_load(model, bodies) : 0;
    if (wrong < bodies)
        return fails(message,
                     "load_mass or load_inertia of body %d: the mass must be at least 0 (kg), the inertia "
                     "symmetric with principal moments of at least 0 (kg m2)",
                     static_cast<int>(wrong) + 1);
    for (size_t k = 0; k < model.links; k++) {
        const Link& link = model.link[k];
        const Variable& variable = model.variable[model.owner[link.from]];
        for (size_t i = 0; link.positive && i < link.size; i++)
            if (!(model.number[link.from + i] > 0.0))
                return fails(message, "%s must be greater than 0 (%s)", variable.name, variable.unit);
    }
    return true;
}

static bool within_guide(const double* guide, const double* state, char* message) {
    for (int i = 0; i < 3; i++) {
        if (guide[3 + i] == 0.0 && (fabs(state[4 + i]) > HELD || fabs(state[10 + i]) > HELD))
            return fails(message, "initial_quaternion or initial_angular_velocity turns about an axis that is held");
        if (guide[i] == 0.0 && fabs(state[7 + i]) > HELD)
            return fails(message, "initial_velocity moves along an axis that is held");
    }
    return true;
}

// Write a state (13) into the frame of the platform, which is known.
static void put(Model& model, const double* state) {
    const Platform& p = model.platform;
    memcpy(p.state, state, 13 * sizeof *state);
    cdpr::ReferenceBegin<double> begin = {p.offset, p.moments + 1, p.state, p.body, p.momentum};
    cdpr::reference_begin(begin);
    if (model.on_ball() && !model.has_winches()) {
        cdpr::SphericalBegin<double> ball = {p.packed, p.state, p.momentum};
        cdpr::spherical_begin(ball);
    }
}

static void put_on_guide(Model& model, const double* state) {
    const double* guide = model.field[GUIDE];
    const cdpr::Vector<double> axis = cdpr::vector(guide + 3);
    const double turn = dot(axis, cdpr::vector(state + 4));
    cdpr::GuidedMotion<double> motion;
    motion.position = cdpr::vector(state);
    motion.velocity = cdpr::along_axes(guide, cdpr::vector(state + 7));
    motion.angle = dot(axis, axis) > 0.0 ? 2.0 * atan2(turn, state[3]) : 0.0;
    motion.spin = dot(axis, cdpr::vector(state + 10));
    store(motion, model.platform.motion);
    cdpr::write_state(guide, motion, model.platform.state);
}

static bool start_platform(Model& model, char* message) {
    const Platform& p = model.platform;
    double state[13];
    memcpy(state, model.field[INITIAL_POSITION], 3 * sizeof *state);
    memcpy(state + 7, model.field[INITIAL_VELOCITY], 3 * sizeof *state);
    memcpy(state + 10, model.field[INITIAL_ANGULAR_VELOCITY], 3 * sizeof *state);
    const cdpr::Quaternion<double> q = cdpr::quaternion(model.field[INITIAL_QUATERNION]);
    if (!(fabs(sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z) - 1.0) <= UNIT))
        return fails(message, "initial_quaternion (w, x, y, z) must have length 1 within 0.001");
    store(cdpr::normalised(q), state + 3);
    if (model.guided() && !within_guide(model.field[GUIDE], state, message)) return false;
    if (model.on_ball() && !model.has_winches()) memset(state + 7, 0, 3 * sizeof *state);
    put(model, state);
    if (model.guided() && !model.on_ball() && !model.has_winches()) put_on_guide(model, state);
    double* zeros[] = {p.tension, p.highest, p.length};
    for (double* array : zeros) memset(array, 0, model.cables * sizeof *array);
    p.cable_work[0] = 0.0;
    memset(p.beside, 0, 6 * sizeof(double));
    memset(p.place, 0, 7 * sizeof(double));
    return true;
}

static bool build(Model& model, char* message) {
    if (!check(model, message)) return false;
    fill_arrays(model);
    if (model.has_platform() && model.inertial) add_loads(model, model.nominal, true, model.inertial);
    if (model.has_platform() && !build_body(model))
        return fails(message, "inertia must be symmetric and positive definite (kg m2)");
    return true;
}

bool retune(Model& model, char* message) {
    double before[13];
    memcpy(before, model.platform.state, sizeof before);
    if (!build(model, message)) return false;
    // On a hinge the frame is that of the platform, for all parameters.
    if (model.has_platform() && (!model.guided() || model.on_ball() || model.has_winches())) put(model, before);
    memcpy(model.platform.state, before, sizeof before);
    publish(model);
    return true;
}

bool start(Model& model, char* message) {
    *model.decisions = 0.0;
    *model.platform.period = model.field[PHYSICS_STEP] ? *model.field[PHYSICS_STEP] : 1.0;
    *model.platform.loaded_at = *model.field[TIME];
    for (size_t i = 0; i < model.states; i++) model.winch[i] = NAN;
    if (!build(model, message)) return false;
    if (model.has_platform() && !start_platform(model, message)) return false;
    publish(model);
    if (!sound(model)) return fails(message, "the initial state is not finite");
    return true;
}

}  // namespace fmu
