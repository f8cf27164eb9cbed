/* The kernel `law` of pid.py; the numbers are kp, kd, ki and the limits of the integral. SPDX-License-Identifier: Apache-2.0 */
#include "laws.h"

static double within(double value, double limit) {
    const double least = value < -limit ? -limit : value;
    return least > limit ? limit : least;
}

void pid_law(const Known *known, double *memory, const double *state, const double *desired, double *wrench) {
    const double *ki = known->numbers + 12, *limit = known->numbers + 18;
    const Vector rest = {0.0, 0.0, 0.0};
    const Vector e = logarithm(multiply(quaternion(desired + 3), conjugate(quaternion(state + 3))));
    const double turned[3] = {e.x, e.y, e.z};
    Vector linear, angular;
    proportional_derivative(state, desired, known->numbers, &linear, &angular);
    for (int i = 0; i < 6; i++) {
        const double error = i < 3 ? desired[i] - state[i] : turned[i - 3];
        const double z = memory[i], change = ki[i] * known->control_step * error;
        if (known->delivered || z * change < 0.0) memory[i] = within(z + change, limit[i]);
    }
    inverse_dynamics(known, quaternion(state + 3), rest, add(linear, vector(memory)), add(angular, vector(memory + 3)),
                     wrench);
}
