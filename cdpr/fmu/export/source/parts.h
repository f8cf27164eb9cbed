/* What cables are made of: exits, winches and spans. SPDX-License-Identifier: Apache-2.0

   Each part of cdpr/cables that has a C file beside it offers the functions of its kernels, with the name of the part
   before them; cdpr/cables/exit.py and chain.py say what they return. The exporter writes the tables, parts.c. */
#ifndef CDPR_PARTS_H
#define CDPR_PARTS_H

#include <stdbool.h>
#include <stddef.h>

#include "vector.h"

/* A row of an exit: the anchor on the frame, and the part's own numbers from NUMBERS on; how many these may be, and how
   many those of a winch or a span. */
enum { NUMBERS = 3, EXIT_NUMBERS = 16, PART_NUMBERS = 8 };

typedef struct {
    double tension, mass;
} Held;

/* P is the anchor on the platform, world axes, and V its velocity. */
typedef Vector Leave(const double *row, Vector P, double *wound); /* the exit point; what lies on it, unless NULL */
typedef Vector Carry(const double *row, Vector P, Vector V);      /* velocity of the exit point */
typedef Held Hold(const double *numbers, double command, double rate, double swing);
typedef double Turn(const double *numbers, double command, double tension, double speed);
typedef double Pull(const double *numbers, double length, double unwound, double stretching, double lowest);
typedef double Rest(const double *numbers, double length, double tension);

typedef struct {
    Leave *leave;
    Carry *carry;
} Exit;

/* Indices into ALL_NUMBERS of what a part takes. */
typedef struct {
    size_t count, index[PART_NUMBERS];
} Taken;

/* The first number is how much cable goes with a unit of the winch's coordinate. */
typedef struct {
    Hold *held;
    Turn *turn;
    bool immediate; /* the tension is the command */
    Taken taken;
} Winch;

typedef struct {
    Pull *pull;
    Rest *rest;
    Taken taken;
} Span;

/* A parameter: one number for each cable. */
typedef struct {
    const char *name, *unit;
    bool positive; /* it must be */
} Number;

/* By the number of their kind, from 1; the first ones are empty: a cable that leaves at its anchor, or that does not
   stretch. */
extern const Exit ALL_EXITS[];
extern const Winch ALL_WINCHES[];
extern const Span ALL_SPANS[];
extern const Number ALL_NUMBERS[];
extern const size_t EXIT_KINDS, WINCH_KINDS, SPAN_KINDS, NUMBER_COUNT;

#endif
