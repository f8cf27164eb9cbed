/* What laws of controllers share, operation by operation as in cdpr/model/kernels.py.
   SPDX-License-Identifier: Apache-2.0 */
#include "laws.h"

#include <math.h>

static const double SMALL_SINE = 1e-8;

Vector logarithm(Quaternion q) {
    const double sine = sqrt(q.x * q.x + q.y * q.y + q.z * q.z), cosine = fabs(q.w);
    const double factor = sine < SMALL_SINE ? 2.0 : 2.0 * atan2(sine, cosine) / sine;
    const double s = q.w < 0.0 ? -factor : factor;
    return (Vector){s * q.x, s * q.y, s * q.z};
}

void proportional_derivative(const double *state, const double *desired, const double *gains, Vector *linear,
                             Vector *angular) {
    const Vector e = logarithm(multiply(quaternion(desired + 3), conjugate(quaternion(state + 3))));
    *linear = (Vector){gains[0] * (desired[0] - state[0]) + gains[6] * (desired[7] - state[7]),
                       gains[1] * (desired[1] - state[1]) + gains[7] * (desired[8] - state[8]),
                       gains[2] * (desired[2] - state[2]) + gains[8] * (desired[9] - state[9])};
    *angular = (Vector){gains[3] * e.x + gains[9] * (desired[10] - state[10]),
                        gains[4] * e.y + gains[10] * (desired[11] - state[11]),
                        gains[5] * e.z + gains[11] * (desired[12] - state[12])};
}

void inverse_dynamics(const Known *known, Quaternion q, Vector omega, Vector a, Vector alpha, double *wrench) {
    const double mass = known->inertial[0], *J = known->inertial + 4;
    const Vector r = rotate(q, vector(known->inertial + 1));
    const Vector tangential = cross(alpha, r), centripetal = cross(omega, cross(omega, r));
    const Vector f = scale(mass, subtract(add(add(a, tangential), centripetal), vector(known->gravity)));
    const Vector euler = turned_product(J, q, alpha), gyroscopic = cross(omega, turned_product(J, q, omega));
    store(f, wrench);
    store(add(add(euler, gyroscopic), cross(r, f)), wrench + 3);
}
