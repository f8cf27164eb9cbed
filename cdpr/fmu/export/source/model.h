/* What winch.c adds to plant.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_MODEL_H
#define CDPR_MODEL_H

#include "body.h"

/* Places in the state of a free platform on ideal cables and of any on winches; the last entry is the angular momentum
   about the centre of mass, world axes, in the first case and the angular velocity in the second. */
enum { P = 0, Q = 3, V = 7, L = 10, W = 10, WINCHES = 13 };

Motion winch_motion(const double *y);
void winch_slope(Plant *plant, const double *y, double *dy);

/* Give elastic cables, where they have none yet, the states at which each tension is its command. */
void winch_begin(Plant *plant);

/* Write tensions, unstretched lengths and drum speeds. */
void winch_publish(Plant *plant);

#endif
