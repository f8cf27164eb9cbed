/* What winch.c and chain.c add to plant.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_MODEL_H
#define CDPR_MODEL_H

#include "body.h"
#include "parts.h"

/* Places in the state of a free platform on ideal cables and of any on winches; the last entry is the angular momentum
   about the centre of mass, world axes, in the first case and the angular velocity in the second. */
enum { P = 0, Q = 3, V = 7, L = 10, W = 10, WINCHES = 13 };

/* A platform on cables with winches: winch.c. */
Motion winch_motion(const double *y);
void winch_slope(Plant *plant, const double *y, double *dy);
void winch_publish(Plant *plant); /* tensions, unwound lengths, drum speeds */

/* Of a platform, free or guided: dynamics.c. `free` (6) is 1 along each direction in which it moves, 0 where the guide
   holds it; the lower half of M is its mass matrix about a frame's origin, world axes, that of the identity there. */
void free_directions(const Plant *plant, double *free);
void mass_matrix(const double *center, const double *inertia, double mass, Quaternion q, const double *free,
                 double M[6][6]);
void mass_solve(double M[6][6], const double *b, double *x); /* M x = b; M is overwritten, NaN where it is singular */

/* Acceleration (6) of the body frame's origin and about it, under the tensions, the external wrench and gravity. */
void accelerate(const Plant *plant, const Motion *at, const double *free, double M[6][6], double *acceleration);
void accelerate_body(const Plant *plant, const Motion *at, const double *free, double *acceleration); /* M is made */

/* Winches and spans: chain.c. `y` holds the states of cables that stretch; `at` is where the platform is, NULL for
   winches alone, to which lengths and rates are given. */
bool chain_stretches(const Plant *plant, size_t i);
bool chain_immediate(const Plant *plant, size_t i); /* whether the tension of cable i is its command */
const Taken *chain_taken(const Plant *plant, size_t i, int part); /* by its winch, 0, or its span, 1 */
void chain_build(Plant *plant);                                   /* write plant->row from the parameters */

/* Write the tensions free of the drums' inertia; unless NULL, that inertia as masses along the cables (n) and the
   cables' columns of the wrench matrix (6 n). Whether there is any such mass. */
bool chain_tell(Plant *plant, const Motion *at, const double *y, double *mass, double *column);
void chain_slopes(const Plant *plant, const double *y, double *dy);
bool chain_begin(const Plant *plant, const Motion *at, double *y); /* unless begun: with each tension as commanded */
void chain_publish(Plant *plant, const double *y);
void actuator_slope(Plant *plant, const double *y, double *dy);
void actuator_publish(Plant *plant);

#endif
