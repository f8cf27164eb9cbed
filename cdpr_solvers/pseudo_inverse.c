/* The kernel of pseudo_inverse.py. SPDX-License-Identifier: Apache-2.0 */
#include "laws.h"

int pseudo_inverse_solve(const Problem *problem, double *tension, double *work) {
    const size_t m = problem->m;
    double *N = work, *box = N + m * m;
    const int r = tension_reduce(problem, box, N, box + 3 * m);
    if (r < 0) return -r;
    for (size_t i = 0; i < m; i++) tension[i] = box[i];
    return STATUS_OK;
}
