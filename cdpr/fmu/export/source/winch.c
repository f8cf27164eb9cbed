/* A platform, free or guided, on cables with winches: cdpr/mechanics/plant.py, integrated as `reference` does.
   SPDX-License-Identifier: Apache-2.0

   Rigid cables carry the drums with them, so these add to the inertia of the platform. */
#include <math.h>
#include <string.h>

#include "model.h"

static const double SINGULAR = 1e-13; /* share of a pivot below which what is left of it is round-off */

Motion winch_motion(const double *y) { return (Motion){vector(y + P), vector(y + V), vector(y + W), quaternion(y + Q)}; }

/* 1 along each of the six directions in which the platform moves, 0 where the guide holds it. */
static void free_directions(const Plant *plant, double *free) {
    for (int i = 0; i < 6; i++) free[i] = plant->field[GUIDE] ? plant->field[GUIDE][i] : 1.0;
}

/* Lower half of the mass matrix about the body frame's origin, world axes; that of the identity where it is held. */
static void mass_matrix(const Plant *plant, Quaternion q, const double *free, double M[6][6]) {
    const double mass = *plant->field[MASS];
    const Vector r = rotate(q, vector(plant->body->center));
    for (int k = 0; k < 6; k++) {
        const Vector unit = {k % 3 == 0, k % 3 == 1, k % 3 == 2}, zero = {0.0, 0.0, 0.0};
        const bool turns = k >= 3;
        const Vector force = scale(mass, turns ? cross(unit, r) : unit);
        const Vector euler = turns ? turned_product(plant->body->inertia, q, unit) : zero;
        double column[6];
        store(force, column);
        store(add(euler, cross(r, force)), column + 3);
        for (int j = k; j < 6; j++) M[j][k] = column[j] * free[j] * free[k];
        if (free[k] == 0.0) M[k][k] = 1.0;
    }
}

/* Solve M x = b by Cholesky's method from the lower half of M, which is overwritten; NaN where M is singular. */
static void solve(double M[6][6], const double *b, double *x) {
    for (int k = 0; k < 6; k++)
        for (int j = 0; j <= k; j++) {
            const double whole = M[k][j];
            for (int i = 0; i < j; i++) M[k][j] -= M[k][i] * M[j][i];
            if (j < k) M[k][j] /= M[j][j];
            else M[k][k] = M[k][k] > SINGULAR * whole ? sqrt(M[k][k]) : NAN;
        }
    for (int k = 0; k < 6; k++) {
        x[k] = b[k];
        for (int j = 0; j < k; j++) x[k] -= M[k][j] * x[j];
        x[k] /= M[k][k];
    }
    for (int k = 5; k >= 0; k--) {
        for (int j = k + 1; j < 6; j++) x[k] -= M[j][k] * x[j];
        x[k] /= M[k][k];
    }
}

/* Acceleration (6) of the body frame's origin and about it, under the tensions, the external wrench and gravity. */
static void accelerate(const Plant *plant, const Motion *at, const double *free, double M[6][6], double *acceleration) {
    const Wrench applied = body_wrench(plant, at);
    const Vector r = rotate(at->attitude, vector(plant->body->center)), w = at->omega;
    const Vector force = scale(*plant->field[MASS], subtract(cross(w, cross(w, r)), vector(plant->field[GRAVITY])));
    const Vector gyroscopic = cross(w, turned_product(plant->body->inertia, at->attitude, w));
    double rest[6];
    store(subtract(applied.force, force), rest);
    store(subtract(applied.moment, add(gyroscopic, cross(r, force))), rest + 3);
    for (int j = 0; j < 6; j++) rest[j] *= free[j];
    solve(M, rest, acceleration);
}

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
        mass_matrix(plant, at->attitude, free, M);
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
    double free[6], M[6][6], acceleration[6];
    free_directions(plant, free);
    tensions(plant, &at, free, y + WINCHES);
    mass_matrix(plant, at.attitude, free, M);
    accelerate(plant, &at, free, M, acceleration);
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
