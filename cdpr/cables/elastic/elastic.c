/* The twin of kernels.py beside it, operation by operation. SPDX-License-Identifier: Apache-2.0 */
#include "parts.h"

enum { STIFFNESS, DAMPING };

double elastic_pull(const double *numbers, double length, double unwound, double stretching, double lowest) {
    const double stretch = length - unwound;
    if (stretch <= 0.0 && lowest == 0.0) return 0.0;
    const double tension = numbers[STIFFNESS] * stretch / unwound + numbers[DAMPING] * stretching;
    return tension < lowest ? lowest : tension;
}

double elastic_rest(const double *numbers, double length, double tension) {
    return length / (1.0 + tension / numbers[STIFFNESS]);
}
