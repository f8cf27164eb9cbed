/* A platform, free or guided, on cables with winches: cdpr/mechanics/plant.py, integrated as `reference` does.
   SPDX-License-Identifier: Apache-2.0

   Rigid cables carry the drums with them, so these add to the inertia of the platform. */
#include <math.h>
#include <string.h>

#include "model.h"

Motion winch_motion(const double *y) { return (Motion){vector(y + P), vector(y + V), vector(y + W), quaternion(y + Q)}; }

/* Take from the tensions what the drums' inertia needs to go with the platform: T = max(0, t - m w . twist'), t without
   it, w = [u ; c]. Which cables pull is found by turns, from the acceleration with those of the last; one turn is enough
   if all do. */
static void share(Plant *plant, const Motion *at, const double *free, const double *mass, const double *column) {
    const size_t n = plant->cables;
    double *T = plant->field[CABLE_TENSION], *light = plant->work + 7 * n, *pulls = light + n;
    for (size_t i = 0; i < n; i++) light[i] = T[i], pulls[i] = 1.0;
    bool changed = true;
    for (size_t turn = 0; changed && turn < 2 * n + 2; turn++) {
        double M[6][6], acceleration[6];
        mass_matrix(plant->body->center, plant->body->inertia, *plant->field[MASS], at->attitude, free, M);
        for (size_t i = 0; i < n; i++) {
            const double *w = column + 6 * i, m = pulls[i] * mass[i];
            for (int j = 0; j < 6; j++)
                for (int k = 0; k <= j; k++) M[j][k] += m * w[j] * w[k] * free[j] * free[k];
            T[i] = pulls[i] * light[i];
        }
        accelerate(plant, at, free, M, acceleration);
        changed = false;
        for (size_t i = 0; i < n; i++) {
            const double *w = column + 6 * i;
            double along = 0.0;
            for (int j = 0; j < 6; j++) along += w[j] * acceleration[j];
            T[i] = light[i];
            if (mass[i] == 0.0) continue;
            T[i] = light[i] - mass[i] * along;
            const bool slack = T[i] < 0.0 && *plant->field[UNILATERAL] != 0.0;
            changed = changed || slack == (pulls[i] == 1.0);
            pulls[i] = slack ? 0.0 : 1.0;
            if (slack) T[i] = 0.0;
        }
    }
}

static void tensions(Plant *plant, const Motion *at, const double *free, const double *y) {
    double *mass = plant->work, *column = mass + plant->cables;
    if (chain_tell(plant, at, y, mass, column)) share(plant, at, free, mass, column);
}

void winch_slope(Plant *plant, const double *y, double *dy) {
    const Motion at = winch_motion(y);
    double free[6], acceleration[6];
    free_directions(plant, free);
    tensions(plant, &at, free, y + WINCHES);
    accelerate_body(plant, &at, free, acceleration);
    store(at.velocity, dy + P);
    store_quaternion(spin(at.omega, at.attitude), dy + Q);
    memcpy(dy + V, acceleration, sizeof acceleration);
    if (plant->states > WINCHES) chain_slopes(plant, y + WINCHES, dy + WINCHES);
}

void winch_publish(Plant *plant) {
    const Motion at = winch_motion(plant->state);
    double free[6], *y = plant->state + WINCHES;
    free_directions(plant, free);
    const bool before = chain_begin(plant, &at, y); /* the outputs are then those with which it would begin */
    tensions(plant, &at, free, y);
    chain_publish(plant, y);
    if (before) memset(y, 0, (plant->states - WINCHES) * sizeof *y);
}
