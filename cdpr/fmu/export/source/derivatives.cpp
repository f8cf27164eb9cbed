// Directional derivatives of the outputs of a platform without winches: the kernels with dual numbers, exact except for
// round-off. SPDX-License-Identifier: Apache-2.0
//
// All quantities are about the platform's origin in world axes. Quaternions set by the host are normalised; a guided
// platform uses only its free directions.
#include <math.h>
#include <cdpr/mechanics/attitude.hpp>
#include <cdpr/mechanics/guide.hpp>

#include "dual.h"
#include "outputs.h"

namespace fmu {

using cdpr::Dual;
using Vector = cdpr::Vector<double>;

static_assert(sizeof(Dual) == 2 * sizeof(double));

// Scratch space: chains, lines, command, tension, length, rate, matrix, runs.
size_t dual_size(const Model& model) {
    return 2 * model.cables *
           (size_t(cdpr::ChainRow<double>::WIDTH) + model.width + 4 + 6 + cdpr::CableRun<double>::COUNT);
}

// Numbers of a field and their changes along the seed.
struct Seeded {
    const Model& model;
    const double* seed;

    const double* change(Name name) const { return seed + (model.field[name] - model.number); }
    void read(Name name, size_t count, Dual* to) const {
        for (size_t i = 0; i < count; i++) to[i] = {model.field[name][i], change(name)[i]};
    }
};

static Vector free_part(const Model& model, int first, Vector v) {
    return model.guided() ? cdpr::along_axes(model.field[GUIDE] + first, v) : v;
}

// Change of the attitude as a rotation vector.
static Vector turn(const Seeded& seeded, cdpr::Quaternion<double> q) {
    const double* given = seeded.model.field[INITIAL_QUATERNION];
    const cdpr::Quaternion<double> change = cdpr::quaternion(seeded.change(INITIAL_QUATERNION));
    const cdpr::Quaternion<double> spun = multiply(change, conjugate(q));
    const double norm = sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2] + given[3] * given[3]);
    return (2.0 / norm) * Vector{spun.x, spun.y, spun.z};  // the part along q goes into spun.w
}

static void write_state(const Seeded& seeded, Dual* state) {
    const Model& model = seeded.model;
    const cdpr::Quaternion<double> q = cdpr::quaternion(model.field[QUATERNION]);
    double change[13];
    store(cdpr::vector(seeded.change(INITIAL_POSITION)), change);
    store(turning(q, free_part(model, 3, turn(seeded, q))), change + 3);
    store(free_part(model, 0, cdpr::vector(seeded.change(INITIAL_VELOCITY))), change + 7);
    store(free_part(model, 3, cdpr::vector(seeded.change(INITIAL_ANGULAR_VELOCITY))), change + 10);
    const Name names[] = {POSITION, QUATERNION, VELOCITY, ANGULAR_VELOCITY};
    const int sizes[] = {3, 4, 3, 3};
    int place = 0;
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < sizes[k]; i++, place++) state[place] = {model.field[names[k]][i], change[place]};
}

static void write_lines(const Seeded& seeded, Dual* lines) {
    const Model& model = seeded.model;
    for (size_t i = 0; i < model.cables * model.width; i++) lines[i] = model.lines[i];
    for (size_t k = 0; k < model.links; k++) {
        const Link& link = model.link[k];
        if (model.array[link.array].data != model.lines) continue;
        for (size_t i = 0; i < link.size; i++) lines[link.to + i].change = seeded.seed[link.from + i];
    }
}

static void write_slopes(const Model& model, double* slope, Name name, const Dual* from, size_t count) {
    for (size_t i = 0; i < count; i++) slope[model.field[name] - model.number + i] = from[i].change;
}

void differentiate(const Model& model, const double* seed, double* slope) {
    const Seeded seeded = {model, seed};
    const size_t m = model.cables;
    Dual* next = reinterpret_cast<Dual*>(model.dual);
    const auto take = [&](size_t count) {
        Dual* place = next;
        next += count;
        return place;
    };
    Dual *chains = take(size_t(cdpr::ChainRow<double>::WIDTH) * m), *lines = take(model.width * m), *tension = take(m),
         *length = take(m), *rate = take(m);
    Dual *matrix = take(6 * m), *runs = take(size_t(cdpr::CableRun<double>::COUNT) * m);
    Dual state[13], inertial[13], free[6], gravity[3], external[6], applied[6], acceleration[6], beside[6];
    Dual offset[7] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
    write_state(seeded, state);
    write_lines(seeded, lines);
    seeded.read(MASS, 1, inertial);
    seeded.read(CENTER_OF_MASS, 3, inertial + 1);
    seeded.read(INERTIA, 9, inertial + 4);
    seeded.read(GRAVITY, 3, gravity);
    seeded.read(EXTERNAL_FORCE, 3, external);
    seeded.read(EXTERNAL_MOMENT, 3, external + 3);
    seeded.read(CABLE_TENSION, m, tension);
    for (size_t i = 0; i < m; i++)
        if (tension[i] < model.lowest()) tension[i] = 0.0;
    for (size_t i = 0; i < size_t(cdpr::ChainRow<double>::WIDTH) * m; i++) chains[i] = 0.0;
    for (int i = 0; i < 6; i++) free[i] = model.platform.free[i];
    for (int i = 0; i < 6; i++) beside[i] = 0.0;
    cdpr::Plant<Dual> plant = {};
    plant.chains = chains;
    plant.lines = lines;
    plant.offset = offset;
    plant.inertial = inertial;
    plant.free = free;
    plant.gravity = gravity;
    plant.external = external;
    plant.body = state;
    plant.tension = tension;
    plant.length = length;
    plant.rate = rate;
    plant.beside = beside;
    plant.applied = applied;
    plant.matrix = matrix;
    plant.runs = runs;
    plant.kinds = model.kinds;
    plant.m = int64_t(m);
    plant.w = int64_t(model.width);
    observe(plant, acceleration);
    write_slopes(model, slope, POSITION, state, 3);
    write_slopes(model, slope, QUATERNION, state + 3, 4);
    write_slopes(model, slope, VELOCITY, state + 7, 3);
    write_slopes(model, slope, ANGULAR_VELOCITY, state + 10, 3);
    write_slopes(model, slope, CABLE_LENGTH, length, m);
    write_slopes(model, slope, CABLE_RATE, rate, m);
    write_slopes(model, slope, ACCELERATION, acceleration, 3);
    write_slopes(model, slope, ANGULAR_ACCELERATION, acceleration + 3, 3);
}

}  // namespace fmu
