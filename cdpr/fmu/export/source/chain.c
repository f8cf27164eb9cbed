/* Winches and spans, cable by cable: cdpr/mechanics/plant.py. SPDX-License-Identifier: Apache-2.0

   A cable that stretches has two states: the length that is unwound, and after those of all cables the speed of its
   winch. They are 0 before it has begun, and always 0 of cables that do not stretch. */
#include <math.h>
#include <string.h>

#include "model.h"

static const Winch *winch_of(const Plant *plant, size_t i) { return ALL_WINCHES + (size_t)plant->field[CHAIN][2 * i]; }

static const Span *span_of(const Plant *plant, size_t i) { return ALL_SPANS + (size_t)plant->field[CHAIN][2 * i + 1]; }

static const double *winch_numbers(const Plant *plant, size_t i) { return plant->row + 2 * PART_NUMBERS * i; }

static const double *span_numbers(const Plant *plant, size_t i) { return winch_numbers(plant, i) + PART_NUMBERS; }

bool chain_stretches(const Plant *plant, size_t i) { return span_of(plant, i)->pull != NULL; }

bool chain_immediate(const Plant *plant, size_t i) { return winch_of(plant, i)->immediate; }

const Taken *chain_taken(const Plant *plant, size_t i, int part) {
    return part == 0 ? &winch_of(plant, i)->taken : &span_of(plant, i)->taken;
}

static double lowest(const Plant *plant) { return *plant->field[UNILATERAL] != 0.0 ? 0.0 : -INFINITY; }

void chain_build(Plant *plant) {
    for (size_t i = 0; plant->field[CHAIN] && i < plant->cables; i++)
        for (int part = 0; part < 2; part++) {
            const Taken *taken = chain_taken(plant, i, part);
            double *numbers = plant->row + (2 * i + part) * PART_NUMBERS;
            memset(numbers, 0, PART_NUMBERS * sizeof *numbers);
            for (size_t k = 0; k < taken->count; k++) numbers[k] = plant->field[FIELDS + taken->index[k]][i];
        }
}

/* Length and rate of cable i where the platform is, or as given if there is none. */
static Line line_of(const Plant *plant, const Motion *at, size_t i) {
    if (at) return body_cable(plant, at, i);
    return (Line){.length = plant->field[CABLE_LENGTH][i], .rate = plant->field[CABLE_RATE][i]};
}

/* The tension that cable i makes by itself, N; and the mass along it that its drum is, kg, which takes its part. */
static Held held(const Plant *plant, const Motion *at, const Line *line, size_t i, const double *y) {
    const double *numbers = winch_numbers(plant, i);
    const double command = plant->field[COMMAND][i];
    if (chain_stretches(plant, i)) {
        const double stretching = line->rate + numbers[0] * y[plant->cables + i];
        const double *own = span_numbers(plant, i);
        return (Held){span_of(plant, i)->pull(own, line->length, y[i], stretching, lowest(plant)), 0.0};
    }
    const bool pushed = chain_immediate(plant, i) && command < lowest(plant); /* which a cable cannot */
    const double swing = at ? body_swing(plant, at, i, line) : 0.0;
    return winch_of(plant, i)->held(numbers, pushed ? 0.0 : command, line->rate, swing);
}

bool chain_tell(Plant *plant, const Motion *at, const double *y, double *mass, double *column) {
    bool heavy = false;
    for (size_t i = 0; i < plant->cables; i++) {
        const Line line = line_of(plant, at, i);
        const Held own = held(plant, at, &line, i, y);
        plant->field[CABLE_TENSION][i] = own.tension;
        if (mass) mass[i] = own.mass;
        heavy = heavy || own.mass != 0.0;
        if (!column) continue;
        store(line.u, column + 6 * i);
        store(line.c, column + 6 * i + 3);
    }
    return heavy;
}

void chain_slopes(const Plant *plant, const double *y, double *dy) {
    const size_t n = plant->cables;
    for (size_t i = 0; i < n; i++) {
        const double *numbers = winch_numbers(plant, i), speed = y[n + i];
        dy[i] = dy[n + i] = 0.0;
        if (!chain_stretches(plant, i)) continue;
        dy[i] = -numbers[0] * speed;
        dy[n + i] = winch_of(plant, i)->turn(numbers, plant->field[COMMAND][i], plant->field[CABLE_TENSION][i], speed);
    }
}

static bool begun(const Plant *plant, const double *y) {
    for (size_t i = 0; i < plant->cables; i++)
        if (chain_stretches(plant, i)) return y[i] != 0.0;
    return true;
}

bool chain_begin(const Plant *plant, const Motion *at, double *y) {
    if (begun(plant, y)) return false;
    for (size_t i = 0; i < plant->cables; i++) {
        if (!chain_stretches(plant, i)) continue;
        const Line line = line_of(plant, at, i);
        y[i] = span_of(plant, i)->rest(span_numbers(plant, i), line.length, plant->field[COMMAND][i]);
        y[plant->cables + i] = -line.rate / winch_numbers(plant, i)[0];
    }
    return true;
}

void chain_publish(Plant *plant, const double *y) {
    for (size_t i = 0; i < plant->cables; i++) {
        const bool own = chain_stretches(plant, i);
        const double along = winch_numbers(plant, i)[0], rate = plant->field[CABLE_RATE][i];
        plant->field[DRUM_SPEED][i] = own ? y[plant->cables + i] : along != 0.0 ? -rate / along : 0.0;
        if (plant->field[UNSTRETCHED_LENGTH])
            plant->field[UNSTRETCHED_LENGTH][i] = own ? y[i] : plant->field[CABLE_LENGTH][i];
    }
}

void actuator_slope(Plant *plant, const double *y, double *dy) {
    chain_tell(plant, NULL, y, NULL, NULL);
    chain_slopes(plant, y, dy);
}

void actuator_publish(Plant *plant) {
    double *y = plant->state;
    const bool before = chain_begin(plant, NULL, y); /* the outputs are then those with which it would begin */
    chain_tell(plant, NULL, y, NULL, NULL);
    chain_publish(plant, y);
    if (before) memset(y, 0, plant->states * sizeof *y);
}
