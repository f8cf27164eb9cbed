/* Derivatives of the outputs of a platform without winches, by differentiating what they are made of: exact but for
   round-off. SPDX-License-Identifier: Apache-2.0

   All is about the platform's origin in world axes; a d before a name is its change along the seed. A quaternion that is
   set is made one of unit length; a guided platform takes of what is set only what its guide leaves free. */
#include <math.h>

#include "model.h"

typedef struct {
    Vector position, turn, velocity, omega; /* `turn` is a rotation vector */
} Change;

/* The change of a field along the seed. */
static const double *of(const Plant *plant, const double *seed, size_t field) {
    return seed + (plant->field[field] - plant->number);
}

/* Where the derivative of a field is written. */
static double *to(const Plant *plant, double *slope, size_t field) {
    return slope + (plant->field[field] - plant->number);
}

static Vector turned_by(const Plant *plant, const double *seed, Quaternion q) {
    const Quaternion dq = quaternion(of(plant, seed, INITIAL_QUATERNION)), spun = multiply(dq, conjugate(q));
    const double *given = plant->field[INITIAL_QUATERNION];
    const double norm = sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2] + given[3] * given[3]);
    return scale(2.0 / norm, (Vector){spun.x, spun.y, spun.z}); /* the part along q goes into spun.w */
}

static Change change_of(const Plant *plant, const double *seed, const Motion *at) {
    Change change = {vector(of(plant, seed, INITIAL_POSITION)), turned_by(plant, seed, at->attitude),
                     vector(of(plant, seed, INITIAL_VELOCITY)), vector(of(plant, seed, INITIAL_ANGULAR_VELOCITY))};
    const double *guide = plant->field[GUIDE];
    if (!guide) return change;
    change.turn = along(vector(guide + 3), change.turn);
    change.omega = along(vector(guide + 3), change.omega);
    change.velocity = along(vector(guide), change.velocity);
    return change;
}

/* Add cable i to the change of the cables' wrench, and write that of its length and rate. */
static void cable(const Plant *plant, const double *seed, const Motion *at, const Change *d, size_t i, Wrench *change,
                  double *slope) {
    double row[NUMBERS + EXIT_NUMBERS];
    const Exit *exit = body_exit(plant, i, row);
    const Vector b = rotate(at->attitude, vector(plant->field[PLATFORM_ANCHORS] + 3 * i));
    const Vector own = rotate(at->attitude, vector(of(plant, seed, PLATFORM_ANCHORS) + 3 * i));
    const Vector db = add(cross(d->turn, b), own), end = add(at->position, b), dend = add(d->position, db);
    const Vector A = vector(plant->field[FRAME_ANCHORS] + 3 * i), dA = vector(of(plant, seed, FRAME_ANCHORS) + 3 * i);
    double wound = 0.0;
    const Vector l = subtract(exit ? exit->leave(row, end, &wound) : A, end), apart = subtract(dA, dend);
    /* An exit goes with its anchor, and beside that as the platform's anchor seen from there makes it. */
    const Vector dE = exit ? add(dA, exit->carry(row, end, subtract(dend, dA))) : dA, dl = subtract(dE, dend);
    const double span = sqrt(dot(l, l));
    const Vector u = divide(l, span), du = divide(subtract(dl, scale(dot(u, dl), u)), span);
    const Vector c = cross(b, u), dc = add(cross(db, u), cross(b, du));
    to(plant, slope, CABLE_LENGTH)[i] = dot(u, apart); /* what lies on the exit included: it leaves along u */
    to(plant, slope, CABLE_RATE)[i] =
        -dot(du, at->velocity) - dot(u, d->velocity) - dot(dc, at->omega) - dot(c, d->omega);
    const double tension = plant->field[CABLE_TENSION][i];
    const bool pushed = plant_pulls_only(plant) && tension < 0.0;
    const double T = pushed ? 0.0 : tension, dT = pushed ? 0.0 : of(plant, seed, CABLE_TENSION)[i];
    change->force = add(change->force, add(scale(dT, u), scale(T, du)));
    change->moment = add(change->moment, add(scale(dT, c), scale(T, dc)));
}

/* Of the balance  m K = force, J_w alpha + w x J_w w + m r x K = moment,  K = a + alpha x r + w x (w x r) - g. */
static void accelerations(const Plant *plant, const double *seed, const Motion *at, const Change *d, Wrench change,
                          double *slope) {
    const double m = *plant->field[MASS], dm = *of(plant, seed, MASS);
    const double *J = plant->field[INERTIA], *dJ = of(plant, seed, INERTIA), *center = plant->field[CENTER_OF_MASS];
    const Quaternion q = at->attitude;
    const Vector w = at->omega, dw = d->omega, g = vector(plant->field[GRAVITY]), dg = vector(of(plant, seed, GRAVITY));
    const Vector a = vector(plant->field[ACCELERATION]), alpha = vector(plant->field[ANGULAR_ACCELERATION]);
    const Vector r = rotate(q, vector(center));
    const Vector dr = add(cross(d->turn, r), rotate(q, vector(of(plant, seed, CENTER_OF_MASS))));
    const Vector K = subtract(add(a, add(cross(alpha, r), cross(w, cross(w, r)))), g);
    const Vector swung = add(cross(dw, cross(w, r)), cross(w, add(cross(dw, r), cross(w, dr))));
    const Vector dK = subtract(add(cross(alpha, dr), swung), dg); /* with the accelerations as they are */
    const Vector Jw = turned_product(J, q, w), Jalpha = turned_product(J, q, alpha);
    /* d(R J R') x = turn x J_w x - J_w (turn x x) + R dJ R' x */
    const Vector dJalpha = add(subtract(cross(d->turn, Jalpha), turned_product(J, q, cross(d->turn, alpha))),
                               turned_product(dJ, q, alpha));
    const Vector dJw = add(subtract(cross(d->turn, Jw), turned_product(J, q, cross(d->turn, w))),
                           add(turned_product(dJ, q, w), turned_product(J, q, dw)));
    const Vector inert = add(scale(dm, K), scale(m, dK));
    const Vector spun = add(dJalpha, add(cross(dw, Jw), cross(w, dJw)));
    const Vector levered = add(cross(r, inert), scale(m, cross(dr, K)));
    double free[6], M[6][6], rest[6], result[6];
    store(subtract(change.force, inert), rest);
    store(subtract(change.moment, add(spun, levered)), rest + 3);
    free_directions(plant, free);
    for (int j = 0; j < 6; j++) rest[j] *= free[j];
    mass_matrix(center, J, m, q, free, M);
    mass_solve(M, rest, result);
    store(vector(result), to(plant, slope, ACCELERATION));
    store(vector(result + 3), to(plant, slope, ANGULAR_ACCELERATION));
}

void plant_differentiate(const Plant *plant, const double *seed, double *slope) {
    const Motion at = {vector(plant->field[POSITION]), vector(plant->field[VELOCITY]),
                       vector(plant->field[ANGULAR_VELOCITY]), quaternion(plant->field[QUATERNION])};
    const Change d = change_of(plant, seed, &at);
    const Vector push = vector(of(plant, seed, EXTERNAL_FORCE)), turn = vector(of(plant, seed, EXTERNAL_MOMENT));
    Wrench change = {push, turn};
    store(d.position, to(plant, slope, POSITION));
    store_quaternion(spin(d.turn, at.attitude), to(plant, slope, QUATERNION));
    store(d.velocity, to(plant, slope, VELOCITY));
    store(d.omega, to(plant, slope, ANGULAR_VELOCITY));
    for (size_t i = 0; i < plant->cables; i++) cable(plant, seed, &at, &d, i, &change, slope);
    accelerations(plant, seed, &at, &d, change, slope);
}
