/* The kernel `law` of static.py. SPDX-License-Identifier: Apache-2.0 */
#include "laws.h"

void static_law(const Known *known, double *memory, const double *state, const double *desired, double *wrench) {
    const Vector rest = {0.0, 0.0, 0.0};
    Vector linear, angular;
    (void)memory;
    proportional_derivative(state, desired, known->numbers, &linear, &angular);
    inverse_dynamics(known, quaternion(state + 3), rest, linear, angular, wrench);
}
