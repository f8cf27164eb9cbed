/* What winch.c adds to plant.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_MODEL_H
#define CDPR_MODEL_H

#include "body.h"

/* Places in the state of a free platform on ideal cables and of any on winches; the last entry is the angular momentum
   about the centre of mass, world axes, in the first case and the angular velocity in the second. */
enum { P = 0, Q = 3, V = 7, L = 10, W = 10, WINCHES = 13 };

/* A platform on cables with winches: winch.c. */
Motion winch_motion(const double *y);
void winch_slope(Plant *plant, const double *y, double *dy);
void winch_publish(Plant *plant); /* tensions, unstretched lengths, drum speeds */

/* Winches: drums.c. `y` holds the states of elastic cables; `at` is where the platform is, NULL for winches
   alone, to which lengths and rates are given. */
double drum_friction(const Plant *plant, size_t i, double speed);
void elastic_tensions(Plant *plant, const Motion *at, const double *y);
void drum_slopes(const Plant *plant, const double *y, double *dy);
void elastic_begin(const Plant *plant, const Motion *at, double *y); /* if not begun: with each tension as commanded */
void elastic_publish(Plant *plant, const Motion *at, double *y);
void actuator_slope(Plant *plant, const double *y, double *dy);

#endif
