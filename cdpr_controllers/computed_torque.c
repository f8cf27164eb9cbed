/* The kernel `law` of computed_torque.py. SPDX-License-Identifier: Apache-2.0 */
#include "laws.h"

void computed_torque_law(const Known *known, double *memory, const double *state, const double *desired, double *wrench) {
    Vector linear, angular;
    (void)memory;
    proportional_derivative(state, desired, known->numbers, &linear, &angular);
    inverse_dynamics(known, quaternion(state + 3), vector(state + 10), add(vector(desired + 13), linear),
                     add(vector(desired + 16), angular), wrench);
}
