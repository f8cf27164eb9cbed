/* The twin of kernels.py beside it, operation by operation. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "parts.h"

enum { RADIUS, INERTIA, VISCOUS, COULOMB, COULOMB_SPEED };

static double friction(const double *numbers, double speed) {
    return numbers[VISCOUS] * speed + numbers[COULOMB] * tanh(speed / numbers[COULOMB_SPEED]);
}

Held drum_held(const double *numbers, double command, double rate, double swing) {
    const double radius = numbers[RADIUS], mass = numbers[INERTIA] / (radius * radius);
    return (Held){command - friction(numbers, -rate / radius) / radius + mass * swing, mass};
}

double drum_turn(const double *numbers, double command, double tension, double speed) {
    return (numbers[RADIUS] * (command - tension) - friction(numbers, speed)) / numbers[INERTIA];
}
