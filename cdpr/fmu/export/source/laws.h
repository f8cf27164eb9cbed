/* What controllers and tension solvers in C offer and share. SPDX-License-Identifier: Apache-2.0

   A controller or solver of cdpr with a C file beside its module offers the function of its kernel, called NAME_law or
   NAME_solve; the exporter writes chosen.c, which says what an FMU has. */
#ifndef CDPR_LAWS_H
#define CDPR_LAWS_H

#include <stdbool.h>
#include <stddef.h>

#include "vector.h"

enum { LAW_MEMORY = 16 }; /* numbers that a controller may remember at most */

/* What a controller knows: its options, one after the other; mass, centre of mass (3), inertia (9); gravity (3). */
typedef struct {
    const double *numbers, *inertial, *gravity;
    double control_step;
    bool delivered; /* whether the cables did what was asked of them in the step before */
} Known;

/* `state` (13) and `desired` (19) as cdpr.model says; write the wrench (6). */
typedef void Law(const Known *known, double *memory, const double *state, const double *desired, double *wrench);

/* W t = wrench, W (n, m) row by row, low <= t <= high. */
typedef struct {
    size_t n, m;
    const double *W, *wrench, *low, *high;
} Problem;

/* Numbered as cdpr.tension.Status. */
enum { STATUS_OK, INFEASIBLE, NOT_FOUND, UNSUPPORTED, BAD_INPUT };

/* Write the tensions (m), return a status; `work` has work_size(n, m) numbers. */
typedef int Solve(const Problem *problem, double *tension, double *work);

extern Law *const CHOSEN_LAW; /* NULL without a controller */
extern Solve *const CHOSEN_SOLVE;
extern const bool CHOSEN_RESPECTS_BOUNDS; /* whether the solver minds the limits */

/* As in cdpr.model.kernels. */
Vector logarithm(Quaternion q);
void proportional_derivative(const double *state, const double *desired, const double *gains, Vector *linear,
                             Vector *angular);
void inverse_dynamics(const Known *known, Quaternion q, Vector omega, Vector a, Vector alpha, double *wrench);

/* As in cdpr.tension: null_space.reduce, verdict.settle and checks.accept. Of what `reduce` writes, box is (3, m),
   N (m, m), its columns first; work is (n + 5, max(n, m)). */
size_t work_size(size_t n, size_t m);
int tension_reduce(const Problem *problem, double *box, double *N, double *work);
int tension_settle(const Problem *problem, const double *box, double *tension);
int tension_accept(const Problem *problem, const double *weights, const double *answer, double *tension);

#endif
