/* The equations of motion and the classical Runge-Kutta scheme, operation by operation those of `reference`.
   SPDX-License-Identifier: Apache-2.0

   On ideal cables, the state of a free platform is position, attitude and velocity of the body frame and its angular
   momentum in world axes, which a free body keeps to round-off; so is that of a platform on a ball, which turns about
   its origin and does not move; that of another guided one is position and velocity of the origin, angle about the
   hinge and its rate. On winches see winch.c; for winches alone chain.c. */
#include "plant.h"

#include <math.h>
#include <string.h>

#include "model.h"

enum { GUIDED_V = 3, ANGLE = 6, SPIN = 7 }; /* places in the state of a guided platform */

static const double UNIT = 1e-3; /* a quaternion's length may differ from 1 by this: typed numbers are rounded */
static const double HELD = 1e-9; /* rad, m/s, rad/s along held directions that count as none: round-off */
static const double WHOLE = 1e-9; /* share of a duration by which it may miss a multiple of the step: round-off */

static Motion free_motion(const Plant *plant, const double *y) {
    const double *J = plant->body->inertia;
    const Quaternion q = quaternion(y + Q);
    const Vector spun = rotate(conjugate(q), vector(y + L));
    const Vector omega = rotate(q, (Vector){spun.x / J[0], spun.y / J[4], spun.z / J[8]});
    return (Motion){vector(y + P), vector(y + V), omega, q};
}

static void free_slope(const Plant *plant, const double *y, double *dy) {
    const Motion at = free_motion(plant, y);
    const Wrench applied = body_wrench(plant, &at);
    store(at.velocity, dy + P);
    store_quaternion(spin(at.omega, at.attitude), dy + Q);
    store(add(divide(applied.force, *plant->field[MASS]), vector(plant->field[GRAVITY])), dy + V);
    store(applied.moment, dy + L);
}

bool plant_on_ball(const Plant *plant) {
    const double *guide = plant->field[GUIDE];
    return guide && guide[3] + guide[4] + guide[5] > 1.0;
}

static Motion ball_motion(const Plant *plant, const double *y) {
    const Quaternion q = quaternion(y + Q);
    return (Motion){vector(y + P), vector(y + V), turned_product(plant->body->inverse, q, vector(y + L)), q};
}

/* As cdpr_backends.reference_spherical: the angular momentum about the origin changes by the moment about it. */
static void ball_slope(const Plant *plant, const double *y, double *dy) {
    const Vector rest = {0.0, 0.0, 0.0};
    const Motion at = ball_motion(plant, y);
    const Wrench applied = body_wrench(plant, &at);
    const Vector weight = cross(rotate(at.attitude, vector(plant->body->moved)), vector(plant->field[GRAVITY]));
    store(rest, dy + P);
    store_quaternion(spin(at.omega, at.attitude), dy + Q);
    store(rest, dy + V);
    store(add(applied.moment, weight), dy + L);
}

static Motion guided_motion(const Plant *plant, const double *y) {
    const Vector axis = vector(plant->field[GUIDE] + 3);
    const double s = sin(0.5 * y[ANGLE]);
    const Quaternion q = {cos(0.5 * y[ANGLE]), s * axis.x, s * axis.y, s * axis.z};
    return (Motion){vector(y + P), vector(y + GUIDED_V), scale(y[SPIN], axis), q};
}

/* As cdpr.mechanics.guide.guided_acceleration: m v' + m c w' = f and c . m v' + J w' = torque, J about the hinge. */
static void guided_slope(const Plant *plant, const double *y, double *dy) {
    const Motion at = guided_motion(plant, y);
    const Wrench applied = body_wrench(plant, &at);
    const Vector slides = vector(plant->field[GUIDE]), axis = vector(plant->field[GUIDE] + 3);
    const double mass = *plant->field[MASS], w2 = mass * y[SPIN] * y[SPIN];
    const Vector r = rotate(at.attitude, vector(plant->body->center));
    const Vector c = cross(axis, r), weight = scale(mass, vector(plant->field[GRAVITY]));
    const Vector f = along(slides, subtract(add(applied.force, weight), scale(w2, cross(axis, c))));
    const Vector slide = along(slides, c);
    double alpha = 0.0;
    if (dot(axis, axis) > 0.0) {
        const double inertia = dot(axis, product(plant->body->inertia, axis)) + mass * dot(c, c);
        const double torque = dot(axis, applied.moment) + dot(axis, cross(r, weight));
        alpha = (torque - dot(slide, f)) / (inertia - mass * dot(slide, slide));
    }
    store(at.velocity, dy + P);
    store(subtract(divide(f, mass), scale(alpha, slide)), dy + GUIDED_V);
    dy[ANGLE] = y[SPIN];
    dy[SPIN] = alpha;
}

static void slope(Plant *plant, const double *y, double *dy) {
    if (!plant->field[MASS]) actuator_slope(plant, y, dy);
    else if (plant->field[COMMAND]) winch_slope(plant, y, dy);
    else if (plant_on_ball(plant)) ball_slope(plant, y, dy);
    else if (plant->field[GUIDE]) guided_slope(plant, y, dy);
    else free_slope(plant, y, dy);
}

static Motion motion(const Plant *plant, const double *y) {
    if (plant->field[COMMAND]) return winch_motion(y);
    if (plant_on_ball(plant)) return ball_motion(plant, y);
    return plant->field[GUIDE] ? guided_motion(plant, y) : free_motion(plant, y);
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
    const bool hinged = plant->field[GUIDE] && !plant_on_ball(plant); /* then, on ideal cables, the state is an angle */
    if (plant->field[MASS] && (plant->field[COMMAND] || !hinged)) normalise(y0 + Q);
}

static void publish_platform(Plant *plant) {
    const Motion at = motion(plant, plant->state), platform = body_to_platform(plant->body, at);
    store(platform.position, plant->field[POSITION]);
    store_quaternion(platform.attitude, plant->field[QUATERNION]);
    store(platform.velocity, plant->field[VELOCITY]);
    store(platform.omega, plant->field[ANGULAR_VELOCITY]);
    for (size_t i = 0; i < plant->cables; i++) {
        const Line line = body_cable(plant, &at, i);
        plant->field[CABLE_LENGTH][i] = line.length;
        plant->field[CABLE_RATE][i] = line.rate;
    }
    if (plant->field[COMMAND]) winch_publish(plant);
    double free[6], acceleration[6];
    free_directions(plant, free);
    accelerate_body(plant, &at, free, acceleration);
    const Vector a = vector(acceleration), alpha = vector(acceleration + 3), w = at.omega;
    const Vector r = rotate(at.attitude, vector(plant->body->offset)); /* the platform's origin lies at -r */
    store(subtract(subtract(a, cross(alpha, r)), cross(w, cross(w, r))), plant->field[ACCELERATION]);
    store(alpha, plant->field[ANGULAR_ACCELERATION]);
}

void plant_publish(Plant *plant) {
    if (plant->field[MASS]) publish_platform(plant);
    else if (plant->field[CHAIN]) actuator_publish(plant); /* nothing of a controller alone */
}

/* Before a step: cables that stretch begin as they are commanded. */
static void begin(Plant *plant) {
    if (!plant->field[COMMAND]) return;
    if (!plant->field[MASS]) {
        chain_begin(plant, NULL, plant->state);
        return;
    }
    const Motion at = winch_motion(plant->state);
    chain_begin(plant, &at, plant->state + WINCHES);
}

void plant_advance(Plant *plant, double duration) {
    const double h = *plant->field[PHYSICS_STEP];
    double n = floor(duration / h + 0.5);
    const bool whole = n >= 1.0 && fabs(duration - n * h) <= WHOLE * duration;
    if (!whole) n = ceil(duration / h);
    begin(plant);
    for (double i = 0.0; i < n; i += 1.0) step(plant, whole ? h : duration / n);
    plant_publish(plant);
}

bool plant_pulls_only(const Plant *plant) {
    return plant->field[MASS] && !plant->field[COMMAND] && *plant->field[UNILATERAL] != 0.0;
}

double plant_asked(const Plant *plant, size_t i) {
    return plant->field[plant->field[COMMAND] ? COMMAND : CABLE_TENSION][i];
}

/* Whether the tension of cable i is what is asked for, which counts as zero where it is negative. */
static bool pulls_as_asked(const Plant *plant, size_t i) { return !plant->field[COMMAND] || chain_immediate(plant, i); }

size_t plant_pushed(const Plant *plant) {
    size_t i = 0;
    if (*plant->field[UNILATERAL] == 0.0 || plant->field[CONTROL_STEP]) return plant->cables;
    while (i < plant->cables && !(pulls_as_asked(plant, i) && plant_asked(plant, i) < 0.0)) i++;
    return i;
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

static bool positive(const Plant *plant, Field field) {
    if (!plant->field[field]) return true;
    const size_t size = plant->variable[plant->owner[plant->field[field] - plant->number]].size;
    for (size_t i = 0; i < size; i++)
        if (!(plant->field[field][i] > 0.0)) return false;
    return true;
}

/* The numbers that parts take of each cable. */
static bool check_parts(const Plant *plant, char *message) {
    for (size_t i = 0; plant->field[CHAIN] && i < plant->cables; i++)
        for (int part = 0; part < 2; part++) {
            const Taken *taken = chain_taken(plant, i, part);
            for (size_t k = 0; k < taken->count; k++) {
                const Number *number = ALL_NUMBERS + taken->index[k];
                if (!number->positive || plant->field[FIELDS + taken->index[k]][i] > 0.0) continue;
                snprintf(message, MESSAGE, "%s must be greater than 0 (%s)", number->name, number->unit);
                return false;
            }
        }
    return true;
}

static bool check(const Plant *plant, char *message) {
    for (size_t i = 0; i < plant->scalars; i++) {
        const Variable *variable = plant->variable + plant->owner[i];
        if ((variable->role == PARAMETER || variable->role == FIXED) && !isfinite(plant->number[i])) {
            snprintf(message, MESSAGE, "%s is not finite", plant_name(variable->field));
            return false;
        }
    }
    if (!positive(plant, MASS)) return fails(message, "mass must be greater than 0 (kg)");
    if (!positive(plant, PHYSICS_STEP)) return fails(message, "physics_step must be greater than 0 (s)");
    if (!positive(plant, CONTROL_STEP)) return fails(message, "control_step must be greater than 0 (s)");
    return check_parts(plant, message);
}

/* The initial state of the platform's origin. */
static Motion initial(const Plant *plant) {
    double q[4];
    memcpy(q, plant->field[INITIAL_QUATERNION], sizeof q);
    normalise(q);
    return (Motion){vector(plant->field[INITIAL_POSITION]), vector(plant->field[INITIAL_VELOCITY]),
                    vector(plant->field[INITIAL_ANGULAR_VELOCITY]), quaternion(q)};
}

static bool within_guide(const double *guide, Motion at, char *message) {
    const double turns[] = {at.attitude.x, at.attitude.y, at.attitude.z, at.omega.x, at.omega.y, at.omega.z};
    const double velocity[] = {at.velocity.x, at.velocity.y, at.velocity.z};
    for (int i = 0; i < 3; i++) {
        if (guide[3 + i] == 0.0 && (fabs(turns[i]) > HELD || fabs(turns[3 + i]) > HELD))
            return fails(message, "initial_quaternion or initial_angular_velocity turns about an axis that is held");
        if (guide[i] == 0.0 && fabs(velocity[i]) > HELD)
            return fails(message, "initial_velocity moves along an axis that is held");
    }
    return true;
}

static void start_guided(Plant *plant, Motion at) {
    const Vector slides = vector(plant->field[GUIDE]), axis = vector(plant->field[GUIDE] + 3);
    const Vector turn = {at.attitude.x, at.attitude.y, at.attitude.z};
    store(at.position, plant->state + P);
    store(along(slides, at.velocity), plant->state + GUIDED_V);
    plant->state[ANGLE] = dot(axis, axis) > 0.0 ? 2.0 * atan2(dot(axis, turn), at.attitude.w) : 0.0;
    plant->state[SPIN] = dot(axis, at.omega);
}

static void start_free(Plant *plant, Motion at) {
    const bool winches = plant->field[COMMAND] != NULL;
    const double *inertia = plant_on_ball(plant) ? plant->body->about : plant->body->inertia;
    store(at.position, plant->state + P);
    store_quaternion(at.attitude, plant->state + Q);
    store(plant_on_ball(plant) ? (Vector){0.0, 0.0, 0.0} : at.velocity, plant->state + V);
    store(winches ? at.omega : turned_product(inertia, at.attitude, at.omega), plant->state + L);
}

static bool start_platform(Plant *plant, char *message) {
    const double *q = plant->field[INITIAL_QUATERNION], *guide = plant->field[GUIDE];
    if (!(fabs(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0) <= UNIT))
        return fails(message, "initial_quaternion (w, x, y, z) must have length 1 within 0.001");
    const Motion platform = initial(plant), at = body_from_platform(plant->body, platform);
    if (guide && !within_guide(guide, platform, message)) return false;
    if (guide && !plant->field[COMMAND] && !plant_on_ball(plant)) start_guided(plant, at);
    else start_free(plant, at);
    return true;
}

static bool build(Plant *plant, char *message) {
    if (!check(plant, message)) return false;
    chain_build(plant);
    if (plant->field[MASS] && !body_build(plant))
        return fails(message, "inertia must be symmetric and positive definite (kg m2)");
    return true;
}

bool plant_retune(Plant *plant, char *message) {
    const bool platform = plant->field[MASS] != NULL;
    Motion before;
    if (platform) before = body_to_platform(plant->body, motion(plant, plant->state));
    if (!build(plant, message)) return false;
    /* The body frame of a hinged platform is that of the platform, whatever the parameters. */
    if (platform && (!plant->field[GUIDE] || plant_on_ball(plant)))
        start_free(plant, body_from_platform(plant->body, before));
    plant_publish(plant);
    return true;
}

bool plant_start(Plant *plant, char *message) {
    memset(plant->state, 0, plant->states * sizeof *plant->state);
    memset(plant->control, 0, CONTROL_NUMBERS * sizeof *plant->control);
    if (!build(plant, message)) return false;
    if (plant->field[MASS] && !start_platform(plant, message)) return false;
    plant_publish(plant);
    if (!plant_sound(plant)) return fails(message, "the initial state is not finite");
    return true;
}
