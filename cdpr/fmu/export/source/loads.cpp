// Bodies that are attached to the platform for some time, as in cdpr.mechanics.attachments. SPDX-License-Identifier:
// Apache-2.0
#include <math.h>
#include <string.h>

#include "model.h"

namespace fmu {

static const double DUE = 1e-6;  // share of a physics step by which a time may be early: the round-off of clocks

size_t attached_bodies(const Model& model) {
    const double* mass = model.field[LOAD_MASS];
    return mass ? model.variable[model.owner[mass - model.number]].size : 0;
}

static double early(const Model& model) { return DUE * *model.field[PHYSICS_STEP]; }

static bool attached(const Model& model, size_t k, double time) {
    const double now = time + early(model);
    return now >= model.field[LOAD_START][k] && now < model.field[LOAD_END][k];
}

// Add a part to mass times centre.
static void add_moment(double mass, const double* center, double* total) {
    total[0] += mass;
    for (int i = 0; i < 3; i++) total[1 + i] += mass * center[i];
}

// Add the inertia of a part about the common centre (Steiner).
static void add_inertia(double mass, const double* center, const double* inertia, double* total) {
    const double d[3] = {center[0] - total[1], center[1] - total[2], center[2] - total[3]};
    const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            total[4 + 3 * i + j] += inertia[3 * i + j] + mass * ((i == j ? square : 0.0) - d[i] * d[j]);
}

void add_loads(const Model& model, const double* own, bool known, double* total) {
    const double time = *model.platform.loaded_at;
    const double *mass = model.field[LOAD_MASS], *center = model.field[LOAD_CENTER], *J = model.field[LOAD_INERTIA];
    const auto counts = [&](size_t k) {
        return attached(model, k, time) && !(known && model.field[LOAD_KNOWN][k] == 0.0);
    };
    size_t found = 0;
    for (size_t k = 0; k < attached_bodies(model); k++) found += counts(k);
    memcpy(total, own, 13 * sizeof *own);
    if (found == 0) return;
    memset(total, 0, 13 * sizeof *total);
    add_moment(own[0], own + 1, total);
    for (size_t k = 0; k < attached_bodies(model); k++)
        if (counts(k)) add_moment(mass[k], center + 3 * k, total);
    for (int i = 1; i < 4; i++) total[i] /= total[0];
    add_inertia(own[0], own + 1, own + 4, total);
    for (size_t k = 0; k < attached_bodies(model); k++)
        if (counts(k)) add_inertia(mass[k], center + 3 * k, J + 9 * k, total);
}

bool take_loads(Model& model, double time, char* message) {
    double& last = *model.platform.loaded_at;
    bool changed = false;
    for (size_t k = 0; k < attached_bodies(model); k++)
        changed = changed || attached(model, k, time) != attached(model, k, last);
    last = time;
    return !changed || retune(model, message);
}

// Return the first time after `time` and before `end` at which a body is attached or removed; `end` if there is none.
static double next_change(const Model& model, double time, double end) {
    const double margin = early(model);
    double next = end;
    for (size_t k = 0; k < 2 * attached_bodies(model); k++) {
        const double at = model.field[k % 2 ? LOAD_END : LOAD_START][k / 2];
        if (at > time + margin && at < next - margin) next = at;
    }
    return next;
}

bool move(Model& model, double time, double duration, char* message) {
    const double end = time + duration;
    while (take_loads(model, time, message)) {
        const double next = next_change(model, time, end);
        if (next == end) {
            advance(model, duration);
            return true;
        }
        advance(model, next - time);
        time = next;
        duration = end - time;
    }
    return false;
}

}  // namespace fmu
