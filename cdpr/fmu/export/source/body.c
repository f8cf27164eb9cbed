/* The frame in which the body is integrated, as cdpr.mechanics.body_frame chooses it, and the cables on it.
   SPDX-License-Identifier: Apache-2.0

   That of a free platform lies at the centre of mass along the principal axes; that of a guided one at its origin along
   its own axes. Attitudes between the stages of a step are not quite of unit length, so another frame would give other
   numbers, by the order of the scheme. */
#include "body.h"

#include <math.h>
#include <string.h>

static const double DIAGONAL = 1e-14; /* share of the trace below which an entry beside the diagonal is round-off */
static const double DEFINITE = 1e-12; /* share of it that each principal moment must exceed */
static const Vector SIDE = {1.0, 0.59, 0.37}; /* to which principal axes point */
static const double IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* One rotation of Jacobi's method: make A[i][j] vanish, A symmetric, and turn the columns of the axes with it. */
static void annihilate(double A[3][3], double axes[3][3], int i, int j) {
    if (A[i][j] == 0.0) return;
    const double theta = (A[j][j] - A[i][i]) / (2.0 * A[i][j]);
    const double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
    const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int k = 0; k < 3; k++) {
        const double a = A[k][i], b = A[k][j], u = axes[k][i], v = axes[k][j];
        A[k][i] = c * a - s * b, A[k][j] = s * a + c * b;
        axes[k][i] = c * u - s * v, axes[k][j] = s * u + c * v;
    }
    for (int k = 0; k < 3; k++) {
        const double a = A[i][k], b = A[j][k];
        A[i][k] = c * a - s * b, A[j][k] = s * a + c * b;
    }
    A[i][j] = A[j][i] = 0.0;
}

static void exchange(double moments[3], double axes[3][3], int i, int j) {
    if (moments[i] <= moments[j]) return;
    const double moment = moments[i];
    moments[i] = moments[j], moments[j] = moment;
    for (int k = 0; k < 3; k++) {
        const double entry = axes[k][i];
        axes[k][i] = axes[k][j], axes[k][j] = entry;
    }
}

/* Principal moments in ascending order and axes, the columns of a rotation; a diagonal tensor stays as it is. */
static void principal_axes(const double *inertia, double moments[3], double axes[3][3]) {
    double A[3][3];
    memcpy(A, inertia, sizeof A);
    memcpy(axes, IDENTITY, sizeof IDENTITY);
    const double largest = fmax(fabs(A[0][1]), fmax(fabs(A[0][2]), fabs(A[1][2])));
    const bool diagonal = largest <= DIAGONAL * (A[0][0] + A[1][1] + A[2][2]);
    for (int sweep = 0; sweep < 12 && !diagonal; sweep++) { /* converges quadratically: 5 are enough */
        annihilate(A, axes, 0, 1);
        annihilate(A, axes, 0, 2);
        annihilate(A, axes, 1, 2);
    }
    for (int i = 0; i < 3; i++) moments[i] = A[i][i];
    if (diagonal) return;
    exchange(moments, axes, 0, 1);
    exchange(moments, axes, 1, 2);
    exchange(moments, axes, 0, 1);
    Vector axis[3];
    for (int i = 0; i < 3; i++) {
        axis[i] = (Vector){axes[0][i], axes[1][i], axes[2][i]};
        if (dot(SIDE, axis[i]) < 0.0) axis[i] = scale(-1.0, axis[i]);
    }
    if (dot(axis[0], cross(axis[1], axis[2])) < 0.0) axis[0] = scale(-1.0, axis[0]);
    for (int i = 0; i < 3; i++) axes[0][i] = axis[i].x, axes[1][i] = axis[i].y, axes[2][i] = axis[i].z;
}

/* Unit quaternion with w >= 0 of a rotation (Shepperd's method). */
static Quaternion attitude_of(double R[3][3]) {
    const double trace = R[0][0] + R[1][1] + R[2][2];
    double q[4], largest = trace;
    int k = 0;
    for (int i = 0; i < 3; i++)
        if (R[i][i] > largest) largest = R[i][i], k = i + 1;
    q[k] = 0.5 * sqrt(1.0 + 2.0 * largest - trace);
    const double f = 0.25 / q[k];
    if (k == 0) {
        q[1] = f * (R[2][1] - R[1][2]), q[2] = f * (R[0][2] - R[2][0]), q[3] = f * (R[1][0] - R[0][1]);
    } else {
        const int i = k - 1, j = k % 3, l = (k + 1) % 3;
        q[0] = f * (R[l][j] - R[j][l]), q[1 + j] = f * (R[j][i] + R[i][j]), q[1 + l] = f * (R[l][i] + R[i][l]);
    }
    const double sign = q[0] < 0.0 ? -1.0 : 1.0;
    return (Quaternion){sign * q[0], sign * q[1], sign * q[2], sign * q[3]};
}

/* As cdpr.mechanics.spherical.pack: inertia about the origin (Steiner), and its inverse. */
static void about_origin(Body *body, double mass, const double *J, Vector c) {
    const double Jxx = J[0] + mass * (c.y * c.y + c.z * c.z), Jyy = J[4] + mass * (c.x * c.x + c.z * c.z);
    const double Jzz = J[8] + mass * (c.x * c.x + c.y * c.y), Jxy = J[1] - mass * (c.x * c.y);
    const double Jxz = J[2] - mass * (c.x * c.z), Jyz = J[5] - mass * (c.y * c.z);
    const double xx = Jyy * Jzz - Jyz * Jyz, xy = Jxz * Jyz - Jxy * Jzz, xz = Jxy * Jyz - Jxz * Jyy;
    const double yy = Jxx * Jzz - Jxz * Jxz, yz = Jxy * Jxz - Jxx * Jyz, zz = Jxx * Jyy - Jxy * Jxy;
    const double det = Jxx * xx + Jxy * xy + Jxz * xz;
    const double about[9] = {Jxx, Jxy, Jxz, Jxy, Jyy, Jyz, Jxz, Jyz, Jzz};
    const double cofactors[9] = {xx, xy, xz, xy, yy, yz, xz, yz, zz};
    memcpy(body->about, about, sizeof about);
    for (int i = 0; i < 9; i++) body->inverse[i] = cofactors[i] / det;
    store(scale(mass, c), body->moved);
}

bool body_build(Plant *plant) {
    Body *body = plant->body;
    const double *J = plant->field[INERTIA], *center = plant->field[CENTER_OF_MASS];
    const bool guided = plant->field[GUIDE] != NULL;
    double moments[3], axes[3][3];
    principal_axes(J, moments, axes);
    const double least = DEFINITE * (J[0] + J[4] + J[8]);
    if (fabs(J[1] - J[3]) + fabs(J[2] - J[6]) + fabs(J[5] - J[7]) > least) return false;
    if (!(moments[0] > least && moments[1] > least && moments[2] > least)) return false;
    if (guided) memcpy(axes, IDENTITY, sizeof IDENTITY);
    const double transposed[9] = {axes[0][0], axes[1][0], axes[2][0], axes[0][1], axes[1][1],
                                  axes[2][1], axes[0][2], axes[1][2], axes[2][2]};
    const double diagonal[9] = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
    const Vector zero = {0.0, 0.0, 0.0}, from = guided ? zero : vector(center);
    memcpy(body->inertia, guided ? J : diagonal, sizeof body->inertia);
    store(guided ? vector(center) : zero, body->center);
    if (plant_on_ball(plant)) about_origin(body, *plant->field[MASS], J, vector(center));
    store(product(transposed, from), body->offset);
    store_quaternion(attitude_of(axes), body->turn);
    for (size_t i = 0; i < plant->cables; i++) {
        const Vector anchor = vector(plant->field[PLATFORM_ANCHORS] + 3 * i);
        store(product(transposed, subtract(anchor, from)), body->anchor + 3 * i);
    }
    return true;
}

Motion body_from_platform(const Body *body, Motion platform) {
    const Quaternion q = multiply(platform.attitude, quaternion(body->turn));
    const Vector r = rotate(q, vector(body->offset));
    return (Motion){add(platform.position, r), add(platform.velocity, cross(platform.omega, r)), platform.omega, q};
}

Motion body_to_platform(const Body *body, Motion at) {
    const Vector r = rotate(at.attitude, vector(body->offset));
    return (Motion){subtract(at.position, r), subtract(at.velocity, cross(at.omega, r)), at.omega,
                    multiply(at.attitude, conjugate(quaternion(body->turn)))};
}

const Exit *body_exit(const Plant *plant, size_t i, double row[NUMBERS + EXIT_NUMBERS]) {
    const double *own = plant->field[CABLE_EXIT] ? plant->field[CABLE_EXIT] + i * plant->exit : NULL;
    if (!own || own[0] == 0.0) return NULL;
    memset(row, 0, (NUMBERS + EXIT_NUMBERS) * sizeof *row);
    memcpy(row, plant->field[FRAME_ANCHORS] + 3 * i, 3 * sizeof *row);
    memcpy(row + NUMBERS, own + 1, (plant->exit - 1) * sizeof *row);
    return ALL_EXITS + (size_t)own[0];
}

/* From platform to frame; b, the lever of its end on the platform; what lies on the exit, unless NULL. */
static Vector cable_vector(const Plant *plant, const Motion *at, size_t i, Vector *b, double *wound) {
    double row[NUMBERS + EXIT_NUMBERS];
    const Exit *exit = body_exit(plant, i, row);
    *b = rotate(at->attitude, vector(plant->body->anchor + 3 * i));
    const Vector P = add(at->position, *b);
    if (wound) *wound = 0.0;
    const Vector E = exit ? exit->leave(row, P, wound) : vector(plant->field[FRAME_ANCHORS] + 3 * i);
    return subtract(subtract(E, at->position), *b);
}

/* Velocity of the point where cable i leaves the frame; b is the lever of its other end, which moves with V. */
static Vector exit_velocity(const Plant *plant, const Motion *at, size_t i, Vector b, Vector V) {
    double row[NUMBERS + EXIT_NUMBERS];
    const Exit *exit = body_exit(plant, i, row);
    return exit ? exit->carry(row, add(at->position, b), V) : (Vector){0.0, 0.0, 0.0};
}

Line body_cable(const Plant *plant, const Motion *at, size_t i) {
    Line line;
    double wound;
    const Vector l = cable_vector(plant, at, i, &line.b, &wound);
    line.span = sqrt(dot(l, l));
    line.length = line.span + wound;
    line.u = divide(l, line.span);
    line.c = cross(line.b, line.u);
    line.rate = -dot(line.u, at->velocity) - dot(line.c, at->omega);
    return line;
}

double body_swing(const Plant *plant, const Motion *at, size_t i, const Line *line) {
    const Vector db = cross(at->omega, line->b);
    const Vector dE = exit_velocity(plant, at, i, line->b, add(at->velocity, db));
    const Vector dl = subtract(subtract(dE, at->velocity), db);
    const Vector du = divide(subtract(dl, scale(dot(line->u, dl), line->u)), line->span);
    const Vector dc = add(cross(db, line->u), cross(line->b, du));
    return -dot(du, at->velocity) - dot(dc, at->omega);
}

Wrench body_wrench(const Plant *plant, const Motion *at) {
    const Vector push = vector(plant->field[EXTERNAL_FORCE]), turn = vector(plant->field[EXTERNAL_MOMENT]);
    const bool pulls_only = plant_pulls_only(plant);
    Vector force = {0.0, 0.0, 0.0}, moment = {0.0, 0.0, 0.0}, b;
    for (size_t i = 0; i < plant->cables; i++) {
        const Vector l = cable_vector(plant, at, i, &b, NULL);
        const double tension = plant->field[CABLE_TENSION][i], pull = pulls_only && tension < 0.0 ? 0.0 : tension;
        const Vector f = scale(pull / sqrt(dot(l, l)), l);
        force = add(force, f);
        moment = add(moment, cross(b, f));
    }
    /* The push acts at the platform's origin, which lies at -r from that of the body frame. */
    const Vector lever = cross(rotate(at->attitude, vector(plant->body->offset)), push);
    return (Wrench){add(force, push), subtract(add(moment, turn), lever)};
}
