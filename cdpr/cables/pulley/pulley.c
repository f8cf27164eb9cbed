/* The twin of kernels.py beside it, operation by operation. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "parts.h"

static const double TURN = 6.283185307179586, FIRST = -1.5707963267948966;

typedef struct {
    Vector out;
    double c, z, f, sine, cosine;
} Plane;

static Plane plane(const double *row, Vector P) {
    const double radius = row[NUMBERS];
    const Vector axis = vector(row + NUMBERS + 1), d = subtract(P, vector(row));
    Plane at;
    at.z = dot(d, axis);
    const Vector away = subtract(d, scale(at.z, axis));
    const double x = sqrt(dot(away, away));
    at.out = x > 0.0 ? scale(1.0 / x, away) : vector(row + NUMBERS + 4);
    at.c = x - radius;
    at.f = sqrt(x * (x - 2.0 * radius) + at.z * at.z);
    const double per = 1.0 / (at.c * at.c + at.z * at.z);
    at.sine = per * (at.f * at.c + radius * at.z);
    at.cosine = per * (at.f * at.z - radius * at.c);
    return at;
}

Vector pulley_leave(const double *row, Vector P, double *wound) {
    const double radius = row[NUMBERS];
    const Plane at = plane(row, P);
    const double away = radius * (1.0 - at.cosine), up = radius * at.sine, turned = atan2(at.sine, at.cosine);
    const double angle = at.z < 0.0 && at.sine < 0.0 && at.cosine > 0.0 ? NAN : turned; /* too far round */
    if (wound) *wound = radius * (angle >= FIRST ? angle : angle + TURN);
    return add(add(vector(row), scale(away, at.out)), scale(up, vector(row + NUMBERS + 1)));
}

Vector pulley_carry(const double *row, Vector P, Vector V) {
    const double radius = row[NUMBERS];
    const Vector axis = vector(row + NUMBERS + 1);
    const Plane at = plane(row, P);
    const double forth = dot(V, at.out), along = dot(V, axis), far = at.c + radius;
    const double turn = radius * (at.cosine * forth - at.sine * along) / at.f;
    const double swing = far > 0.0 ? radius * (1.0 - at.cosine) / far : 0.0;
    const Vector tangent = add(scale(at.sine, at.out), scale(at.cosine, axis));
    const Vector across = subtract(subtract(V, scale(forth, at.out)), scale(along, axis));
    return add(scale(turn, tangent), scale(swing, across));
}
