/* The plant of cdpr in C: a rigid platform on cables, with winches or without, or the winches alone, integrated as the
   backend `reference` of cdpr does.
   SPDX-License-Identifier: Apache-2.0

   Conventions (cdpr/model/__init__.py): SI units, world axes, z up; quaternions are w, x, y, z; the wrench acts at the
   platform's origin; cable i runs from frame_anchors[i] (world) to platform_anchors[i] (platform axes). */
#ifndef CDPR_PLANT_H
#define CDPR_PLANT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* What the model knows by name. The configuration says which of them there are, where, and in which role. */
typedef enum {
    TIME, PHYSICS_STEP, CABLE_TENSION, CABLE_LENGTH, CABLE_RATE,
    /* of the platform */
    MASS, CENTER_OF_MASS, INERTIA, GRAVITY, FRAME_ANCHORS, PLATFORM_ANCHORS,
    INITIAL_POSITION, INITIAL_QUATERNION, INITIAL_VELOCITY, INITIAL_ANGULAR_VELOCITY,
    EXTERNAL_FORCE, EXTERNAL_MOMENT, POSITION, QUATERNION, VELOCITY, ANGULAR_VELOCITY, ACCELERATION,
    ANGULAR_ACCELERATION,
    UNILATERAL, /* of the cables: 1 if they only pull */
    CABLE_EXIT,  /* only where cables leave the frame otherwise than at their anchors: kind and numbers, see parts.h */
    GUIDE, /* only of guided platforms: 1 along each free axis (3) and about each (3): those of a hinge, or of a ball */
    COMMAND, CHAIN, DRUM_SPEED, /* of winches; CHAIN is the kinds of winch and span of each cable, see parts.h */
    UNSTRETCHED_LENGTH,         /* where a cable stretches */
    /* of a controller: control.c */
    CONTROL_STEP, LAW, BELIEVED, TENSION_MIN, TENSION_MAX, CONTROLLED, POLICY, DESIRED_POSITION, DESIRED_QUATERNION,
    DESIRED_VELOCITY, DESIRED_ANGULAR_VELOCITY, DESIRED_ACCELERATION, DESIRED_ANGULAR_ACCELERATION,
    FAULT, FAULT_TIME, /* only in tests, with CDPR_FAULTS */
    FIELDS /* and behind them the numbers of parts, in the order of ALL_NUMBERS */
} Field;

typedef enum { INDEPENDENT, PARAMETER, FIXED, INPUT, OUTPUT, CONSTANT } Role; /* fixed parameters are those of the start */

typedef struct {
    size_t field;
    Role role;
    size_t offset, size;
} Variable;

enum { CONTROL_NUMBERS = 19 }; /* three and LAW_MEMORY: control.c */

#define MESSAGE 256 /* bytes of a message at most */
#define TOKEN 64    /* bytes of the instantiation token at most */

/* What is derived from the parameters: see body.c. */
typedef struct {
    double center[3], inertia[9]; /* body frame; the inertia is about the centre of mass */
    double moved[3];              /* of a platform on a ball: mass times centre */
    double about[9], inverse[9];  /* and inertia about the origin, and its inverse */
    double offset[3], turn[4];    /* body frame's origin from the platform's, body axes; its attitude in the platform */
    double anchor[];              /* (3 cables) body frame */
} Body;

/* All numbers lie in one array: variables first, in the order of their value references, then what is derived
   from the parameters, then the state. A copy of it is a snapshot. */
typedef struct {
    size_t cables;
    size_t exit; /* numbers of CABLE_EXIT for each cable */
    size_t variables; /* how many there are, constants included */
    Variable *variable;
    size_t scalars;   /* numbers in them */
    size_t *owner;    /* (scalars) index of the variable that a number belongs to */
    size_t states;
    size_t count;     /* numbers in all */
    double *number;   /* (count) */
    double **field;   /* by Field, into `number`; NULL where the robot has no such variable */
    Body *body;
    double *row;      /* (2 PART_NUMBERS cables) what each cable's winch and span take */
    double *state;    /* (states) see plant.c and winch.c */
    double *scratch;  /* (3 states) of the integrator */
    double *control;  /* (CONTROL_NUMBERS) what a controller remembers: control.c */
    double *work;     /* (9 cables) of the winches */
    double *decision; /* of a controller while it decides; NULL without one */
    double *tangent;  /* (2 scalars) of the derivatives */
    char token[TOKEN];
} Plant;

/* How a host knows it. */
const char *plant_name(size_t field);

/* Read the configuration; false with a message where it cannot be used. Free the plant in either case. */
bool plant_load(Plant *plant, FILE *file, char *message);
void plant_free(Plant *plant);

/* Check the parameters and put the platform into its initial state; false with a message where they are unsound. */
bool plant_start(Plant *plant, char *message);

/* Take other parameters than before, the platform being and moving as it was; false with a message as above. */
bool plant_retune(Plant *plant, char *message);

/* Advance by `duration` in steps of physics_step, or slightly shorter ones where that does not divide it. */
void plant_advance(Plant *plant, double duration);

/* Write the outputs that belong to the state and the inputs. */
void plant_publish(Plant *plant);

/* Write the derivatives of the outputs along `seed` (scalars), changes of inputs and, before the first step, of
   parameters; both by value reference, `slope` (scalars) at those of outputs. Of a platform without winches, whose
   outputs have been published. tangent.c */
void plant_differentiate(const Plant *plant, const double *seed, double *slope);

/* Whether the platform turns about all axes and its origin is held. */
bool plant_on_ball(const Plant *plant);

/* Whether tensions are given, not made by winches, to cables that cannot push: a negative one counts as zero. */
bool plant_pulls_only(const Plant *plant);

/* What asks cable i to pull, an input. */
double plant_asked(const Plant *plant, size_t i);

/* The cable that is asked to push though it cannot, counted from 0; the number of cables if there is none. */
size_t plant_pushed(const Plant *plant);

/* Let the controller decide whenever it is due from `time` on, and advance the plant, if there is one, by `duration`;
   false with a message where there is no answer. control.c */
bool control_advance(Plant *plant, double time, double duration, char *message);
bool control_answered(const Plant *plant); /* whether the last wrench was distributed as wanted */
size_t control_room(const Plant *plant);   /* numbers of plant->decision */

/* Whether the state is finite. */
bool plant_sound(const Plant *plant);

#endif
