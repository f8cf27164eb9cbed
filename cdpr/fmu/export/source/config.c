/* Reads resources/plant.cfg, which the exporter writes from the same data as the start values of the model description.
   SPDX-License-Identifier: Apache-2.0

   One line a variable: role, name, value reference, number of values, values. A value stands as the 16 hexadecimal
   digits of its IEEE 754 bits: exact, and read alike whatever the locale of the host. */
#include "laws.h"
#include "model.h"

#include <inttypes.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const char *const ROLES[] = {"independent", "parameter", "fixed", "input", "output", "constant"};

/* What a variable belongs to; it is there if all of that is. */
enum { PLATFORM = 1, WINCH = 2, OPTIONAL = 4, DECIDES = 8, PLANT = 16 };

enum { ANY = 0 }; /* as many numbers for each cable as there are */

static const struct {
    const char *name;
    size_t width;
    bool per_cable;
    int of;
    bool alone; /* a controller alone has it, too */
} KNOWN[FIELDS] = {
    [TIME] = {"time", 1, false, 0},
    [PHYSICS_STEP] = {"physics_step", 1, false, PLANT},
    [CABLE_TENSION] = {"cable_tension", 1, true, PLANT},
    [CABLE_LENGTH] = {"cable_length", 1, true, PLANT},
    [CABLE_RATE] = {"cable_rate", 1, true, PLANT},
    [MASS] = {"mass", 1, false, PLATFORM},
    [CENTER_OF_MASS] = {"center_of_mass", 3, false, PLATFORM},
    [INERTIA] = {"inertia", 9, false, PLATFORM},
    [GRAVITY] = {"gravity", 3, false, PLATFORM},
    [FRAME_ANCHORS] = {"frame_anchors", 3, true, PLATFORM, true},
    [PLATFORM_ANCHORS] = {"platform_anchors", 3, true, PLATFORM, true},
    [INITIAL_POSITION] = {"initial_position", 3, false, PLATFORM},
    [INITIAL_QUATERNION] = {"initial_quaternion", 4, false, PLATFORM},
    [INITIAL_VELOCITY] = {"initial_velocity", 3, false, PLATFORM},
    [INITIAL_ANGULAR_VELOCITY] = {"initial_angular_velocity", 3, false, PLATFORM},
    [EXTERNAL_FORCE] = {"external_force", 3, false, PLATFORM},
    [EXTERNAL_MOMENT] = {"external_moment", 3, false, PLATFORM},
    [POSITION] = {"position", 3, false, PLATFORM, true},
    [QUATERNION] = {"quaternion", 4, false, PLATFORM, true},
    [VELOCITY] = {"velocity", 3, false, PLATFORM, true},
    [ANGULAR_VELOCITY] = {"angular_velocity", 3, false, PLATFORM, true},
    [ACCELERATION] = {"acceleration", 3, false, PLATFORM},
    [ANGULAR_ACCELERATION] = {"angular_acceleration", 3, false, PLATFORM},
    [UNILATERAL] = {"unilateral", 1, false, 0},
    [GUIDE] = {"guide", 6, false, OPTIONAL},
    [CABLE_EXIT] = {"exit", ANY, true, OPTIONAL},
    [COMMAND] = {"command", 1, true, WINCH, true},
    [CHAIN] = {"chain", 2, true, WINCH},
    [DRUM_SPEED] = {"drum_speed", 1, true, WINCH},
    [UNSTRETCHED_LENGTH] = {"unstretched_length", 1, true, OPTIONAL},
    [CONTROL_STEP] = {"control_step", 1, false, DECIDES},
    [LAW] = {"controller", ANY, false, DECIDES}, /* all that begin so, one after the other */
    [BELIEVED] = {"believed", 16, false, DECIDES},
    [TENSION_MIN] = {"tension_min", 1, true, DECIDES},
    [TENSION_MAX] = {"tension_max", 1, true, DECIDES},
    [CONTROLLED] = {"controlled", 6, false, DECIDES},
    [POLICY] = {"policy", 2, false, DECIDES},
    [DESIRED_POSITION] = {"desired_position", 3, false, DECIDES},
    [DESIRED_QUATERNION] = {"desired_quaternion", 4, false, DECIDES},
    [DESIRED_VELOCITY] = {"desired_velocity", 3, false, DECIDES},
    [DESIRED_ANGULAR_VELOCITY] = {"desired_angular_velocity", 3, false, DECIDES},
    [DESIRED_ACCELERATION] = {"desired_acceleration", 3, false, DECIDES},
    [DESIRED_ANGULAR_ACCELERATION] = {"desired_angular_acceleration", 3, false, DECIDES},
    [FAULT] = {"fault", 1, false, OPTIONAL},
    [FAULT_TIME] = {"fault_time", 1, false, OPTIONAL},
};

const char *plant_name(size_t field) { return field < FIELDS ? KNOWN[field].name : ALL_NUMBERS[field - FIELDS].name; }

static bool fails(char *message, const char *what, const char *name) {
    snprintf(message, MESSAGE, "resources/plant.cfg: %s '%s'; it belongs to another version of this library", what, name);
    return false;
}

static int find_role(const char *name) {
    for (int i = 0; i <= CONSTANT; i++)
        if (strcmp(name, ROLES[i]) == 0) return i;
    return -1;
}

/* How many there are where it is not known. */
static size_t find_field(const char *name) {
    size_t i = 0;
    if (strncmp(name, "controller.", 11) == 0) return LAW;
    while (i < FIELDS + NUMBER_COUNT && strcmp(name, plant_name(i)) != 0) i++;
    return i;
}

static bool read_value(FILE *file, double *value) {
    uint64_t bits;
    if (fscanf(file, "%" SCNx64, &bits) != 1) return false;
    memcpy(value, &bits, sizeof bits);
    return true;
}

/* Read one line; the values begin at `next`, which moves behind them. */
static bool read_variable(Plant *plant, FILE *file, size_t index, size_t *next, char *message) {
    char role[16] = "", name[64] = "";
    size_t offset, size;
    if (fscanf(file, "%15s %63s %zu %zu", role, name, &offset, &size) != 4) return fails(message, "broken after", name);
    const int found_role = find_role(role);
    const size_t found = find_field(name);
    const bool more = found == LAW && index > 0 && plant->variable[index - 1].field == LAW;
    if (found_role < 0) return fails(message, "unknown role", role);
    if (found == FIELDS + NUMBER_COUNT || (plant->field[found] && !more)) return fails(message, "unknown or repeated variable", name);
    if (offset != *next || size > plant->scalars - offset) return fails(message, "wrong place of", name);
    *next += size;
    const bool own = found >= FIELDS; /* of a part: one number for each cable */
    const size_t owners = own || KNOWN[found].per_cable ? plant->cables : 1, width = own ? 1 : KNOWN[found].width;
    if (width == ANY ? owners == 0 || size % owners : size != width * owners)
        return fails(message, "wrong number of values of", name);
    if (found == CABLE_EXIT) plant->exit = size / owners;
    if (plant->exit > 1 + EXIT_NUMBERS) return fails(message, "too many values of", name);
    plant->variable[index] = (Variable){found, (Role)found_role, offset, size};
    if (!more) plant->field[found] = plant->number + offset;
    for (size_t i = 0; i < size; i++) {
        plant->owner[offset + i] = index;
        if (!read_value(file, plant->number + offset + i)) return fails(message, "no value of", name);
    }
    return true;
}

static bool allocate(Plant *plant) {
    const size_t body = sizeof *plant->body / sizeof(double) + 3 * plant->cables;
    const size_t rows = 2 * PART_NUMBERS * plant->cables;
    plant->states = 13 + 2 * plant->cables; /* at most */
    plant->count = plant->scalars + body + rows + plant->states + CONTROL_NUMBERS;
    plant->field = calloc(FIELDS + NUMBER_COUNT, sizeof *plant->field);
    plant->variable = calloc(plant->variables, sizeof *plant->variable);
    plant->owner = calloc(plant->scalars, sizeof *plant->owner);
    plant->number = calloc(plant->count, sizeof *plant->number);
    plant->scratch = calloc(3 * plant->states + 9 * plant->cables, sizeof *plant->scratch);
    plant->tangent = calloc(2 * plant->scalars, sizeof *plant->tangent);
    if (!plant->field || !plant->variable || !plant->owner || !plant->number || !plant->scratch || !plant->tangent)
        return false;
    plant->body = (Body *)(plant->number + plant->scalars);
    plant->row = plant->number + plant->scalars + body;
    plant->state = plant->row + rows;
    plant->control = plant->state + plant->states;
    plant->work = plant->scratch + 3 * plant->states;
    return true;
}

static bool kinds_known(const double *kind, size_t each, size_t n, double least, size_t kinds) {
    for (size_t i = 0; i < n; i++)
        if (!(kind[i * each] >= least && kind[i * each] <= (double)kinds && kind[i * each] == floor(kind[i * each])))
            return false;
    return true;
}

/* Whether the kinds of parts are known, there are the numbers that they take, and tensions follow from what there is. */
static bool sound_parts(const Plant *plant, char *message) {
    const double *exit = plant->field[CABLE_EXIT], *chain = plant->field[CHAIN];
    bool stretches = false;
    if (exit && !kinds_known(exit, plant->exit, plant->cables, 0.0, EXIT_KINDS))
        return fails(message, "unknown kind of", plant_name(CABLE_EXIT));
    if (chain && !(kinds_known(chain, 2, plant->cables, 1.0, WINCH_KINDS)
                   && kinds_known(chain + 1, 2, plant->cables, 0.0, SPAN_KINDS)))
        return fails(message, "unknown kind of", plant_name(CHAIN));
    for (size_t i = 0; chain && i < plant->cables; i++) {
        stretches = stretches || chain_stretches(plant, i);
        if (!plant->field[MASS] && !chain_stretches(plant, i) && !chain_immediate(plant, i))
            return fails(message, "winches alone have no", plant_name(CABLE_TENSION));
        for (int part = 0; part < 2; part++)
            for (size_t k = 0; k < chain_taken(plant, i, part)->count; k++) {
                const size_t field = FIELDS + chain_taken(plant, i, part)->index[k];
                if (!plant->field[field]) return fails(message, "missing", plant_name(field));
            }
    }
    if (stretches != (plant->field[UNSTRETCHED_LENGTH] != NULL))
        return fails(message, "missing or useless", plant_name(UNSTRETCHED_LENGTH));
    return true;
}

/* Whether there is all that the model takes: a platform, with winches or without, or winches alone. */
static bool complete(const Plant *plant, char *message) {
    const bool platform = plant->field[MASS] != NULL, winch = plant->field[CHAIN] != NULL;
    const bool decides = plant->field[CONTROL_STEP] != NULL, alone = decides && !platform && !winch;
    const int there = platform * PLATFORM + winch * WINCH + decides * DECIDES + (platform || winch) * PLANT;
    if (decides && (!CHOSEN_LAW || !CHOSEN_SOLVE)) return fails(message, "no", plant_name(LAW));
    if (there == 0) return fails(message, "no model has what is in", "it");
    for (int i = 0; i < FIELDS; i++)
        if (KNOWN[i].of != OPTIONAL
            && (plant->field[i] != NULL) != ((KNOWN[i].of & ~there) == 0 || (alone && KNOWN[i].alone)))
            return fails(message, "missing or useless", KNOWN[i].name);
    return sound_parts(plant, message);
}

bool plant_load(Plant *plant, FILE *file, char *message) {
    const size_t most = 1000000; /* numbers: far above 256 cables */
    memset(plant, 0, sizeof *plant);
    if (fscanf(file, "cdpr-plant 1 token %63s cables %zu variables %zu numbers %zu", plant->token, &plant->cables,
               &plant->variables, &plant->scalars) != 4
        || plant->scalars == 0 || plant->variables == 0 || plant->scalars > most || plant->variables > plant->scalars || plant->cables > plant->scalars)
        return fails(message, "wrong head, token", plant->token);
    if (!allocate(plant)) return fails(message, "no memory for", "numbers");
    size_t next = 0;
    for (size_t i = 0; i < plant->variables; i++)
        if (!read_variable(plant, file, i, &next, message)) return false;
    if (next != plant->scalars) return fails(message, "fewer values than", "numbers");
    if (!complete(plant, message)) return false;
    plant->states = (plant->field[MASS] ? 13 : 0) + (plant->field[UNSTRETCHED_LENGTH] ? 2 * plant->cables : 0);
    if (plant->field[CONTROL_STEP]) plant->decision = calloc(control_room(plant), sizeof *plant->decision);
    if (plant->field[CONTROL_STEP] && !plant->decision) return fails(message, "no memory for", plant_name(LAW));
    return true;
}

void plant_free(Plant *plant) {
    free(plant->field);
    free(plant->variable);
    free(plant->owner);
    free(plant->number);
    free(plant->scratch);
    free(plant->tangent);
    free(plant->decision);
    memset(plant, 0, sizeof *plant);
}
