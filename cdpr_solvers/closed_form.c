/* The kernel of closed_form.py, and what it takes of projection.py. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "laws.h"

static const double ROUND_OFF = 1e-6, BALANCED = 5e-10; /* as in projection.py */

static double square(double a) { return a * a; }

/* Write the solution nearest to the middle of the limits. */
static int nearest_to_middle(size_t m, const double *N, size_t r, const double *box, double *middle, double *tension) {
    double outer = 0.0, distance = 0.0, size = 0.0;
    for (size_t i = 0; i < m; i++) {
        middle[i] = 0.5 * (box[m + i] + box[2 * m + i]);
        if (!isfinite(middle[i])) return UNSUPPORTED;
    }
    for (size_t i = 0; i < m; i++) tension[i] = box[i];
    for (size_t k = 0; k < r; k++) {
        double x = 0.0;
        for (size_t i = 0; i < m; i++) x += N[i * m + k] * middle[i];
        for (size_t i = 0; i < m; i++) tension[i] += N[i * m + k] * x;
    }
    for (size_t i = 0; i < m; i++) {
        outer += square(0.5 * (box[2 * m + i] - box[m + i]));
        distance += square(tension[i] - middle[i]);
        size += square(tension[i]);
    }
    return sqrt(distance) > sqrt(outer) + ROUND_OFF * sqrt(size) ? INFEASIBLE : STATUS_OK;
}

static int admitted(const Problem *problem, size_t r, const double *box, double *tension) {
    const int status = tension_settle(problem, box, tension);
    double lack = 0.0, rows = 0.0;
    if (r == 0) return status;
    for (size_t j = 0; j < problem->n; j++) {
        double s = -problem->wrench[j], size = fabs(problem->wrench[j]);
        for (size_t i = 0; i < problem->m; i++) {
            const double part = problem->W[j * problem->m + i] * tension[i];
            s += part;
            size += fabs(part);
        }
        lack = fabs(s) > lack ? fabs(s) : lack;
        rows = size > rows ? size : rows;
    }
    return status == STATUS_OK && lack <= BALANCED * rows ? STATUS_OK : NOT_FOUND;
}

int closed_form_solve(const Problem *problem, double *tension, double *work) {
    const size_t m = problem->m;
    double *N = work, *box = N + m * m, *middle = box + 3 * m;
    const int r = tension_reduce(problem, box, N, middle + m);
    if (r < 0) return -r;
    const int status = nearest_to_middle(m, N, (size_t)r, box, middle, tension);
    return status == STATUS_OK ? admitted(problem, (size_t)r, box, tension) : status;
}
