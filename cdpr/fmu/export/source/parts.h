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

/* P is the anchor on the platform, world axes, and V its velocity. */
typedef struct {
    Vector (*leave)(const double *row, Vector P, double *wound); /* the exit point; what lies on it, unless NULL */
    Vector (*carry)(const double *row, Vector P, Vector V);      /* velocity of the exit point */
} Exit;

typedef struct {
    double tension, mass;
} Held;

/* Indices into ALL_NUMBERS of what a part takes. */
typedef struct {
    size_t count, index[PART_NUMBERS];
} Taken;

/* The first number is how much cable goes with a unit of the winch's coordinate. */
typedef struct {
    Held (*held)(const double *numbers, double command, double rate, double swing);
    double (*turn)(const double *numbers, double command, double tension, double speed);
    bool immediate; /* the tension is the command */
    Taken taken;
} Winch;

typedef struct {
    double (*pull)(const double *numbers, double length, double unwound, double stretching, double lowest);
    double (*rest)(const double *numbers, double length, double tension);
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
