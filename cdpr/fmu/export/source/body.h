/* The rigid body that is integrated, and the cables on it. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_BODY_H
#define CDPR_BODY_H

#include "parts.h"
#include "plant.h"
#include "vector.h"

typedef struct {
    Vector position, velocity, omega; /* of the body frame's origin, world axes */
    Quaternion attitude;
} Motion;

typedef struct {
    Vector force, moment; /* about the body frame's origin, world axes */
} Wrench;

typedef struct {
    Vector u, c; /* direction from platform to frame, and its moment about the body frame's origin */
    Vector b;    /* lever of the platform's anchor, world axes */
    double span; /* from the exit point to that anchor; the rest of the length lies on the exit */
    double length, rate;
} Line;

/* Compute plant->body from mass, centre of mass, inertia and anchors; false unless the inertia is one. */
bool body_build(Plant *plant);

/* Between the platform's origin along its own axes and the body frame. */
Motion body_from_platform(const Body *body, Motion platform);
Motion body_to_platform(const Body *body, Motion at);

Line body_cable(const Plant *plant, const Motion *at, size_t i);

/* What cable i leaves the frame by, NULL where that is its anchor; `row` as parts.h says. */
const Exit *body_exit(const Plant *plant, size_t i, double row[NUMBERS + EXIT_NUMBERS]);

/* Second rate of a cable's length for a platform that does not accelerate. */
double body_swing(const Plant *plant, const Motion *at, size_t i, const Line *line);

/* Of the cables' tensions and of the external wrench, which acts at the platform's origin. */
Wrench body_wrench(const Plant *plant, const Motion *at);

#endif
