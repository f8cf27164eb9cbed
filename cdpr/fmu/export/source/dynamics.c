/* Mass matrix and acceleration of a platform, free or guided. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "model.h"

static const double SINGULAR = 1e-13; /* share of a pivot below which what is left of it is round-off */

void free_directions(const Plant *plant, double *free) {
    for (int i = 0; i < 6; i++) free[i] = plant->field[GUIDE] ? plant->field[GUIDE][i] : 1.0;
}

void mass_matrix(const double *center, const double *inertia, double mass, Quaternion q, const double *free,
                 double M[6][6]) {
    const Vector r = rotate(q, vector(center));
    for (int k = 0; k < 6; k++) {
        const Vector unit = {k % 3 == 0, k % 3 == 1, k % 3 == 2}, zero = {0.0, 0.0, 0.0};
        const bool turns = k >= 3;
        const Vector force = scale(mass, turns ? cross(unit, r) : unit);
        const Vector euler = turns ? turned_product(inertia, q, unit) : zero;
        double column[6];
        store(force, column);
        store(add(euler, cross(r, force)), column + 3);
        for (int j = k; j < 6; j++) M[j][k] = column[j] * free[j] * free[k];
        if (free[k] == 0.0) M[k][k] = 1.0;
    }
}

/* By Cholesky's method. */
void mass_solve(double M[6][6], const double *b, double *x) {
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

void accelerate(const Plant *plant, const Motion *at, const double *free, double M[6][6], double *acceleration) {
    const Wrench applied = body_wrench(plant, at);
    const Vector r = rotate(at->attitude, vector(plant->body->center)), w = at->omega;
    const Vector force = scale(*plant->field[MASS], subtract(cross(w, cross(w, r)), vector(plant->field[GRAVITY])));
    const Vector gyroscopic = cross(w, turned_product(plant->body->inertia, at->attitude, w));
    double rest[6];
    store(subtract(applied.force, force), rest);
    store(subtract(applied.moment, add(gyroscopic, cross(r, force))), rest + 3);
    for (int j = 0; j < 6; j++) rest[j] *= free[j];
    mass_solve(M, rest, acceleration);
}

void accelerate_body(const Plant *plant, const Motion *at, const double *free, double *acceleration) {
    double M[6][6];
    mass_matrix(plant->body->center, plant->body->inertia, *plant->field[MASS], at->attitude, free, M);
    accelerate(plant, at, free, M, acceleration);
}
