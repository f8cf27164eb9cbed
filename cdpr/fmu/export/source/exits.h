/* Where cables leave the frame, for those that do not at their anchors. SPDX-License-Identifier: Apache-2.0

   Each part of cdpr/cables that has a C file beside it offers two functions; the exporter writes the table, exits.c.
   `row` holds the anchor on the frame and, from NUMBERS on, the part's own numbers; P is the anchor on the platform,
   world axes, and V its velocity. */
#ifndef CDPR_EXITS_H
#define CDPR_EXITS_H

#include <stddef.h>

#include "vector.h"

enum { NUMBERS = 3, EXIT_NUMBERS = 16 }; /* where they begin, and how many there may be */

typedef struct {
    Vector (*leave)(const double *row, Vector P, double *wound); /* the exit point; what lies on it, unless NULL */
    Vector (*carry)(const double *row, Vector P, Vector V);      /* velocity of the exit point */
} Exit;

extern const Exit EXITS[]; /* by the number of their kind, from 1; the first one is empty */
extern const size_t EXIT_KINDS;

#endif
