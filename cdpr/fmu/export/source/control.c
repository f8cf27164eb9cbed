/* Controller, tension solver and what cdpr/tension/stage.py does around it. SPDX-License-Identifier: Apache-2.0

   The controller decides at its start and then once in each control step, whatever steps the host makes; between, its
   tensions or commands are held. */
#include <math.h>
#include <string.h>

#include "body.h"
#include "laws.h"

/* Places in plant->control. */
enum { DECISIONS, BEGAN, STATUS, MEMORY }; /* and from there LAW_MEMORY */

/* In POLICY: what to do without an answer, and the characteristic length, m. */
enum { STOP, HOLD, BEST_EFFORT };

static const double DUE = 1e-6; /* share of a control step by which it may be early: the round-off of clocks */

size_t control_room(const Plant *plant) {
    const size_t m = plant->cables;
    return 6 * m + m + 12 + work_size(6, m);
}

bool control_answered(const Plant *plant) { return plant->control[STATUS] == STATUS_OK; }

static double *take(double *to, const Plant *plant, size_t field, size_t size) {
    memcpy(to, plant->field[field], size * sizeof *to);
    return to + size;
}

/* As cable_geometry of cdpr/mechanics/geometry.py, the rows in which the wrench is to be balanced; how many. */
static size_t balance(const Plant *plant, const double *state, const double *wrench, double *W, double *wanted,
                      double *weights) {
    const size_t m = plant->cables;
    const Vector p = vector(state);
    const Quaternion q = quaternion(state + 3);
    size_t n = 0, place[6];
    for (size_t j = 0; j < 6; j++) {
        place[j] = n;
        if (plant->field[CONTROLLED][j] == 0.0) continue;
        wanted[n] = wrench[j];
        weights[n++] = j < 3 ? 1.0 : 1.0 / plant->field[POLICY][1];
    }
    for (size_t i = 0; i < m; i++) {
        double row[NUMBERS + EXIT_NUMBERS], column[6];
        const Exit *exit = body_exit(plant, i, row);
        const Vector b = rotate(q, vector(plant->field[PLATFORM_ANCHORS] + 3 * i)), end = add(p, b);
        const Vector from = exit ? exit->leave(row, end, NULL) : vector(plant->field[FRAME_ANCHORS] + 3 * i);
        const Vector l = subtract(subtract(from, p), b), u = divide(l, sqrt(dot(l, l)));
        store(u, column);
        store(cross(b, u), column + 3);
        for (size_t j = 0; j < 6; j++)
            if (plant->field[CONTROLLED][j] != 0.0) W[place[j] * m + i] = column[j];
    }
    return n;
}

static bool all_finite(const double *numbers, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

/* Where there is no answer: the tensions before, or those of a solver that minds no limits, within them. */
static bool replace(const Plant *plant, const double *answer, bool answered, double *tension, char *message) {
    const int policy = (int)plant->field[POLICY][0];
    const double *low = plant->field[TENSION_MIN], *high = plant->field[TENSION_MAX];
    const bool clip = policy == BEST_EFFORT && answered && !CHOSEN_RESPECTS_BOUNDS && all_finite(answer, plant->cables);
    if (policy != HOLD && !clip) {
        snprintf(message, MESSAGE, "no tensions within the limits were found for the wrench that the controller wants, and "
                 "this FMU ends there; exported with solver.infeasible hold_tension it goes on with those before");
        return false;
    }
    for (size_t i = 0; i < plant->cables; i++) {
        const double t = clip ? answer[i] : tension[i], least = low[i] > t ? low[i] : t;
        tension[i] = high[i] < least ? high[i] : least;
    }
    return true;
}

static bool decide(Plant *plant, char *message) {
    const size_t m = plant->cables;
    double *memory = plant->control + MEMORY, *W = plant->decision, *answer = W + 6 * m, *wanted = answer + m;
    double *weights = wanted + 6, *work = weights + 6, *tension = plant->field[plant->field[COMMAND] ? COMMAND : CABLE_TENSION];
    double state[13], desired[19], wrench[6];
    double *to = take(take(state, plant, POSITION, 3), plant, QUATERNION, 4);
    take(take(to, plant, VELOCITY, 3), plant, ANGULAR_VELOCITY, 3);
    to = take(take(desired, plant, DESIRED_POSITION, 3), plant, DESIRED_QUATERNION, 4);
    to = take(take(to, plant, DESIRED_VELOCITY, 3), plant, DESIRED_ANGULAR_VELOCITY, 3);
    take(take(to, plant, DESIRED_ACCELERATION, 3), plant, DESIRED_ANGULAR_ACCELERATION, 3);
    const Known known = {plant->field[LAW], plant->field[BELIEVED], plant->field[BELIEVED] + 13,
                         *plant->field[CONTROL_STEP], control_answered(plant)};
    CHOSEN_LAW(&known, memory, state, desired, wrench);
    const size_t n = balance(plant, state, wrench, W, wanted, weights);
    if (!all_finite(wanted, n) || !all_finite(W, n * m)) {
        snprintf(message, MESSAGE, "the controller puts out a wrench that is not finite: an input is not, or it diverges");
        return false;
    }
    const Problem problem = {n, m, W, wanted, plant->field[TENSION_MIN], plant->field[TENSION_MAX]};
    int status = CHOSEN_SOLVE(&problem, answer, work);
    const bool answered = status == STATUS_OK;
    if (answered) status = tension_accept(&problem, weights, answer, tension);
    plant->control[STATUS] = status;
    return status == STATUS_OK || replace(plant, answer, answered, tension, message);
}

bool control_advance(Plant *plant, double time, double duration, char *message) {
    double *control = plant->control, end = time + duration;
    const double step = *plant->field[CONTROL_STEP], early = DUE * step;
    if (control[DECISIONS] == 0.0) control[BEGAN] = time;
    while (time < end - early || (time < end && duration <= early)) {
        if (time >= control[BEGAN] + control[DECISIONS] * step - early) {
            if (!decide(plant, message)) return false;
            control[DECISIONS] += 1.0;
        }
        const double next = control[BEGAN] + control[DECISIONS] * step, until = next < end - early ? next : end;
        if (plant->field[MASS]) plant_advance(plant, until - time);
        time = until;
    }
    return true;
}
