/* The equations of motion and the classical Runge-Kutta scheme, operation by operation those of `reference`.
   SPDX-License-Identifier: Apache-2.0

   State of a free platform: position p and attitude q of the centre of mass's frame, its velocity v, the angular
   momentum L about it in world axes (which a free body keeps to round-off). Of a guided one: position of the origin,
   velocity of it, angle about the hinge and its rate. */
#include "plant.h"

#include <math.h>
#include <string.h>

enum { P = 0, Q = 3, V = 7, L = 10 };               /* places in the state of a free platform */
enum { GP = 0, GV = 3, ANGLE = 6, SPIN = 7 };       /* of a guided one */

static const double UNIT = 1e-3; /* a quaternion's length may differ from 1 by this: typed numbers are rounded */
static const double HELD = 1e-9; /* rad, m/s, rad/s along held directions that count as none: round-off */
static const double WHOLE = 1e-9; /* share of a step by which a duration may miss a multiple: round-off of clocks */

typedef struct {
    double x, y, z;
} Vector;

typedef struct {
    double w, x, y, z;
} Quaternion;

static Vector vector(const double *a) { return (Vector){a[0], a[1], a[2]}; }
static Quaternion quaternion(const double *a) { return (Quaternion){a[0], a[1], a[2], a[3]}; }
static void store(Vector v, double *a) { a[0] = v.x, a[1] = v.y, a[2] = v.z; }
static Vector add(Vector a, Vector b) { return (Vector){a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vector subtract(Vector a, Vector b) { return (Vector){a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vector scale(double s, Vector v) { return (Vector){s * v.x, s * v.y, s * v.z}; }
static double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vector along(Vector a, Vector b) { return (Vector){a.x * b.x, a.y * b.y, a.z * b.z}; }

static Vector cross(Vector a, Vector b) {
    return (Vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static Vector rotate(Quaternion q, Vector v) {
    const Vector axis = {q.x, q.y, q.z};
    const Vector t = scale(2.0, cross(axis, v));
    return add(add(v, scale(q.w, t)), cross(axis, t));
}

static Quaternion conjugate(Quaternion q) { return (Quaternion){q.w, -q.x, -q.y, -q.z}; }

/* A v, A being 3 x 3, row by row. */
static Vector product(const double *A, Vector v) {
    return (Vector){A[0] * v.x + A[1] * v.y + A[2] * v.z, A[3] * v.x + A[4] * v.y + A[5] * v.z,
                    A[6] * v.x + A[7] * v.y + A[8] * v.z};
}

/* Factor the inertia, L D L^T; false unless it is symmetric and positive definite. A diagonal one stays exact. */
static bool factor(const double *J, double *f) {
    const double tiny = 1e-12 * (J[0] + J[4] + J[8]);
    f[0] = J[0];
    f[3] = J[3] / f[0];
    f[4] = J[6] / f[0];
    f[1] = J[4] - f[3] * f[3] * f[0];
    f[5] = (J[7] - f[4] * f[3] * f[0]) / f[1];
    f[2] = J[8] - f[4] * f[4] * f[0] - f[5] * f[5] * f[1];
    const double skew = fabs(J[1] - J[3]) + fabs(J[2] - J[6]) + fabs(J[5] - J[7]);
    return f[0] > tiny && f[1] > tiny && f[2] > tiny && skew <= tiny;
}

/* omega = R J^-1 R^T L */
static Vector angular_velocity(const double *f, Quaternion q, Vector momentum) {
    Vector w = rotate(conjugate(q), momentum);
    w.y -= f[3] * w.x;
    w.z -= f[4] * w.x + f[5] * w.y;
    w = (Vector){w.x / f[0], w.y / f[1], w.z / f[2]};
    w.y -= f[5] * w.z;
    w.x -= f[3] * w.y + f[4] * w.z;
    return rotate(q, w);
}

typedef struct {
    Vector position, velocity, omega; /* of a point of the platform */
    Quaternion attitude;
    Vector origin; /* platform axes: where the platform's anchors are measured from */
} Motion;

typedef struct {
    Vector force, moment;
} Wrench;

/* Cable i: vector from platform to frame; b, its lever in world axes. */
static Vector cable(const Plant *plant, const Motion *at, size_t i, Vector *b) {
    const Vector anchor = subtract(vector(plant->field[PLATFORM_ANCHORS] + 3 * i), at->origin);
    *b = rotate(at->attitude, anchor);
    return subtract(subtract(vector(plant->field[FRAME_ANCHORS] + 3 * i), at->position), *b);
}

/* Force and moment of all cables about the point `at`, world axes. */
static Wrench cable_wrench(const Plant *plant, const Motion *at) {
    Wrench sum = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (size_t i = 0; i < plant->cables; i++) {
        Vector b;
        const Vector l = cable(plant, at, i, &b);
        const Vector f = scale(plant->field[CABLE_TENSION][i] / sqrt(dot(l, l)), l);
        sum.force = add(sum.force, f);
        sum.moment = add(sum.moment, cross(b, f));
    }
    return sum;
}

static Motion free_motion(const Plant *plant, const double *y) {
    const Quaternion q = quaternion(y + Q);
    return (Motion){vector(y + P), vector(y + V), angular_velocity(plant->factors, q, vector(y + L)), q,
                    vector(plant->field[CENTER_OF_MASS])};
}

static void free_slope(const Plant *plant, const double *y, double *dy) {
    const Motion at = free_motion(plant, y);
    const Wrench pull = cable_wrench(plant, &at);
    const double *external = plant->field[EXTERNAL_WRENCH];
    const Vector push = vector(external), w = at.omega;
    const Quaternion q = at.attitude;
    const Vector f = add(pull.force, push);
    const double mass = *plant->field[MASS], *g = plant->field[GRAVITY];
    store(at.velocity, dy + P);
    dy[Q] = -0.5 * (w.x * q.x + w.y * q.y + w.z * q.z);
    dy[Q + 1] = 0.5 * (w.x * q.w + w.y * q.z - w.z * q.y);
    dy[Q + 2] = 0.5 * (w.y * q.w + w.z * q.x - w.x * q.z);
    dy[Q + 3] = 0.5 * (w.z * q.w + w.x * q.y - w.y * q.x);
    store((Vector){f.x / mass + g[0], f.y / mass + g[1], f.z / mass + g[2]}, dy + V);
    /* The push acts at the origin, which lies at -R c from the centre of mass. */
    const Vector lever = cross(rotate(q, at.origin), push);
    store(subtract(add(pull.moment, vector(external + 3)), lever), dy + L);
}

static Quaternion hinge(Vector axis, double angle) {
    const double s = sin(0.5 * angle);
    return (Quaternion){cos(0.5 * angle), s * axis.x, s * axis.y, s * axis.z};
}

static Motion guided_motion(const Plant *plant, const double *y) {
    const Vector axis = vector(plant->field[GUIDE] + 3);
    return (Motion){vector(y + GP), vector(y + GV), scale(y[SPIN], axis), hinge(axis, y[ANGLE]), {0.0, 0.0, 0.0}};
}

/* As cdpr.model.guide.guided_acceleration: m v' + m c w' = f and c . m v' + J w' = torque, J about the hinge. */
static void guided_slope(const Plant *plant, const double *y, double *dy) {
    const Motion at = guided_motion(plant, y);
    const Wrench pull = cable_wrench(plant, &at);
    const double *external = plant->field[EXTERNAL_WRENCH];
    const Vector force = add(pull.force, vector(external)), moment = add(pull.moment, vector(external + 3));
    const Vector slides = vector(plant->field[GUIDE]), axis = vector(plant->field[GUIDE] + 3);
    const double mass = *plant->field[MASS], w2 = mass * y[SPIN] * y[SPIN];
    const Vector r = rotate(at.attitude, vector(plant->field[CENTER_OF_MASS]));
    const Vector c = cross(axis, r), weight = scale(mass, vector(plant->field[GRAVITY]));
    const Vector f = along(slides, subtract(add(force, weight), scale(w2, cross(axis, c))));
    const Vector slide = along(slides, c);
    double alpha = 0.0;
    if (dot(axis, axis) > 0.0) {
        const double inertia = dot(axis, product(plant->field[INERTIA], axis)) + mass * dot(c, c);
        const double torque = dot(axis, moment) + dot(axis, cross(r, weight));
        alpha = (torque - dot(slide, f)) / (inertia - mass * dot(slide, slide));
    }
    store(at.velocity, dy + GP);
    store(subtract((Vector){f.x / mass, f.y / mass, f.z / mass}, scale(alpha, slide)), dy + GV);
    dy[ANGLE] = y[SPIN];
    dy[SPIN] = alpha;
}

static void slope(const Plant *plant, const double *y, double *dy) {
    (plant->field[GUIDE] ? guided_slope : free_slope)(plant, y, dy);
}

static void normalise(double *q) {
    const double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) q[i] /= norm;
}

/* One step of the classical Runge-Kutta scheme, cables and tensions evaluated at every stage. */
static void step(Plant *plant, double h) {
    const size_t n = plant->states;
    double *y0 = plant->state, *y = plant->scratch, *k = y + n, *sum = k + n;
    memcpy(y, y0, n * sizeof *y);
    memset(k, 0, 2 * n * sizeof *k);
    for (int stage = 0; stage < 4; stage++) {
        const double weight = stage == 0 || stage == 3 ? 1.0 : 2.0, c = stage == 2 ? h : 0.5 * h;
        slope(plant, y, k);
        for (size_t i = 0; i < n; i++) {
            sum[i] += weight * k[i];
            y[i] = y0[i] + c * k[i];
        }
    }
    for (size_t i = 0; i < n; i++) y0[i] += h / 6.0 * sum[i];
    if (!plant->field[GUIDE]) normalise(y0 + Q);
}

/* Write pose, twist, lengths and rates of the platform. */
static void publish(Plant *plant) {
    const bool guided = plant->field[GUIDE] != NULL;
    const Motion at = (guided ? guided_motion : free_motion)(plant, plant->state);
    const Vector r = rotate(at.attitude, at.origin);
    store(subtract(at.position, r), plant->field[POSITION]);
    memcpy(plant->field[QUATERNION], &at.attitude, sizeof at.attitude);
    store(subtract(at.velocity, cross(at.omega, r)), plant->field[VELOCITY]);
    store(at.omega, plant->field[ANGULAR_VELOCITY]);
    for (size_t i = 0; i < plant->cables; i++) {
        Vector b;
        const Vector l = cable(plant, &at, i, &b);
        const double length = sqrt(dot(l, l));
        const Vector u = {l.x / length, l.y / length, l.z / length};
        plant->field[CABLE_LENGTH][i] = length;
        plant->field[CABLE_RATE][i] = -dot(u, at.velocity) - dot(cross(b, u), at.omega);
    }
}

void plant_advance(Plant *plant, double duration) {
    const double h = *plant->field[PHYSICS_STEP];
    double n = floor(duration / h + 0.5);
    const bool whole = n >= 1.0 && fabs(duration - n * h) <= WHOLE * duration;
    if (!whole) n = ceil(duration / h);
    for (double i = 0.0; i < n; i += 1.0) step(plant, whole ? h : duration / n);
    publish(plant);
}

bool plant_sound(const Plant *plant) {
    for (size_t i = 0; i < plant->states; i++)
        if (!isfinite(plant->state[i])) return false;
    return true;
}

static bool fails(char *message, const char *what) {
    snprintf(message, MESSAGE, "%s", what);
    return false;
}

static bool check(const Plant *plant, char *message) {
    for (size_t i = 0; i < plant->variables; i++) {
        const Variable *variable = plant->variable + i;
        for (size_t j = 0; variable->role == PARAMETER && j < variable->size; j++)
            if (!isfinite(plant->number[variable->offset + j])) {
                snprintf(message, MESSAGE, "the parameter with value reference %zu is not finite", variable->offset + j);
                return false;
            }
    }
    if (!(*plant->field[MASS] > 0.0)) return fails(message, "mass must be greater than 0 (kg)");
    if (!(*plant->field[PHYSICS_STEP] > 0.0)) return fails(message, "physics_step must be greater than 0 (s)");
    return true;
}

static void start_free(Plant *plant) {
    double *y = plant->state;
    memcpy(y + Q, plant->field[INITIAL_QUATERNION], 4 * sizeof *y);
    normalise(y + Q);
    const Quaternion q = quaternion(y + Q);
    const Vector r = rotate(q, vector(plant->field[CENTER_OF_MASS]));
    const Vector omega = vector(plant->field[INITIAL_ANGULAR_VELOCITY]);
    store(add(vector(plant->field[INITIAL_POSITION]), r), y + P);
    store(add(vector(plant->field[INITIAL_VELOCITY]), cross(omega, r)), y + V);
    store(rotate(q, product(plant->field[INERTIA], rotate(conjugate(q), omega))), y + L);
}

static bool start_guided(Plant *plant, char *message) {
    const double *guide = plant->field[GUIDE], *q = plant->field[INITIAL_QUATERNION];
    double *y = plant->state;
    memset(y, 0, plant->states * sizeof *y);
    for (int i = 0; i < 3; i++) {
        const double v = plant->field[INITIAL_VELOCITY][i], w = plant->field[INITIAL_ANGULAR_VELOCITY][i];
        if (fabs((1.0 - guide[3 + i]) * q[1 + i]) > HELD || fabs((1.0 - guide[3 + i]) * w) > HELD)
            return fails(message, "initial_quaternion or initial_angular_velocity turns about an axis that the guide holds");
        if (fabs((1.0 - guide[i]) * v) > HELD)
            return fails(message, "initial_velocity moves along an axis that the guide holds");
        y[GV + i] = guide[i] * v;
        y[SPIN] += guide[3 + i] * w;
        y[ANGLE] += guide[3 + i] * 2.0 * atan2(q[1 + i], q[0]);
    }
    memcpy(y + GP, plant->field[INITIAL_POSITION], 3 * sizeof *y);
    return true;
}

bool plant_start(Plant *plant, char *message) {
    const double *q = plant->field[INITIAL_QUATERNION];
    if (!check(plant, message)) return false;
    if (!factor(plant->field[INERTIA], plant->factors))
        return fails(message, "inertia must be symmetric and positive definite (kg m2)");
    if (!(fabs(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0) <= UNIT))
        return fails(message, "initial_quaternion (w, x, y, z) must have length 1 within 0.001");
    if (!plant->field[GUIDE]) start_free(plant);
    else if (!start_guided(plant, message)) return false;
    publish(plant);
    if (!plant_sound(plant)) return fails(message, "the initial state is not finite");
    return true;
}
