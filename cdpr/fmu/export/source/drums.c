/* Drums, friction and elastic cables, cable by cable: cdpr/cables/winch.py. SPDX-License-Identifier: Apache-2.0

   A drum of radius r turns at w, positive where it winds in; the command u is the tension that the motor would hold at
   rest: I w' = r u - f(w) - r T. An elastic cable has two states: unstretched length l0, then, after those of all cables,
   the speed of its drum. l0 = 0 means: not begun. */
#include <math.h>
#include <string.h>

#include "model.h"

double drum_friction(const Plant *plant, size_t i, double speed) {
    return plant->field[VISCOUS_FRICTION][i] * speed
        + plant->field[COULOMB_FRICTION][i] * tanh(speed / plant->field[COULOMB_SPEED][i]);
}

/* Length and rate of cable i where the platform is, or as given if there is none. */
static Line line_of(const Plant *plant, const Motion *at, size_t i) {
    if (at) return body_cable(plant, at, i);
    return (Line){.length = plant->field[CABLE_LENGTH][i], .rate = plant->field[CABLE_RATE][i]};
}

void elastic_tensions(Plant *plant, const Motion *at, const double *y) {
    const bool unilateral = *plant->field[UNILATERAL] != 0.0;
    for (size_t i = 0; i < plant->cables; i++) {
        const Line line = line_of(plant, at, i);
        const double stretch = line.length - y[i], speed = y[plant->cables + i];
        const double pull = plant->field[AXIAL_STIFFNESS][i] * stretch / y[i]
            + plant->field[DAMPING][i] * (line.rate + plant->field[DRUM_RADIUS][i] * speed);
        const bool slack = unilateral && (stretch <= 0.0 || pull < 0.0);
        plant->field[CABLE_TENSION][i] = slack ? 0.0 : pull;
    }
}

void drum_slopes(const Plant *plant, const double *y, double *dy) {
    const size_t n = plant->cables;
    for (size_t i = 0; i < n; i++) {
        const double radius = plant->field[DRUM_RADIUS][i], speed = y[n + i];
        const double torque = radius * (plant->field[COMMAND][i] - plant->field[CABLE_TENSION][i]);
        dy[i] = -radius * speed;
        dy[n + i] = (torque - drum_friction(plant, i, speed)) / plant->field[DRUM_INERTIA][i];
    }
}

void elastic_begin(const Plant *plant, const Motion *at, double *y) {
    if (y[0] != 0.0) return;
    for (size_t i = 0; i < plant->cables; i++) {
        const Line line = line_of(plant, at, i);
        y[i] = line.length / (1.0 + plant->field[COMMAND][i] / plant->field[AXIAL_STIFFNESS][i]);
        y[plant->cables + i] = -line.rate / plant->field[DRUM_RADIUS][i];
    }
}

void elastic_publish(Plant *plant, const Motion *at, double *y) {
    const size_t bytes = plant->cables * sizeof *y;
    const bool begun = y[0] != 0.0;
    elastic_begin(plant, at, y); /* before the first step, the outputs are those with which it would begin */
    elastic_tensions(plant, at, y);
    memcpy(plant->field[UNSTRETCHED_LENGTH], y, bytes);
    memcpy(plant->field[DRUM_SPEED], y + plant->cables, bytes);
    if (!begun) memset(y, 0, 2 * bytes);
}

void actuator_slope(Plant *plant, const double *y, double *dy) {
    elastic_tensions(plant, NULL, y);
    drum_slopes(plant, y, dy);
}
