/* The twin of kernels.py beside it, operation by operation. SPDX-License-Identifier: Apache-2.0 */
#include "parts.h"

Held direct_held(const double *numbers, double command, double rate, double swing) {
    (void)numbers, (void)rate, (void)swing;
    return (Held){command, 0.0};
}

double direct_turn(const double *numbers, double command, double tension, double speed) {
    (void)numbers, (void)command, (void)tension, (void)speed;
    return 0.0;
}
