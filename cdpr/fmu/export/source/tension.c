/* What tension solvers share, and the checks of their answers, operation by operation as in cdpr/tension.
   SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "laws.h"

/* null_space.py, verdict.py and checks.py say what these are. */
static const double RANK_TOLERANCE = 1e-9, CONSISTENCY_TOLERANCE = 1e-9, ROUNDING = 1e-11, TOO_LARGE = 1e300;
static const double VERTEX_TOLERANCE = 1e-9, ROUND_OFF = 1e-12, STRICTER = 0.1, LARGE = 1e-3;
static const double LIMIT_TOLERANCE = 1e-6, RESIDUAL_TOLERANCE = 1e-6, FAR = 0x1p-520;

static double larger(double a, double b) { return b > a ? b : a; }
static double smaller(double a, double b) { return b < a ? b : a; }

static size_t width_of(size_t n, size_t m) { return n > m ? n : m; }

size_t work_size(size_t n, size_t m) { return (2 * m + n + 16) * width_of(n, m); }

static void swap(double *a, double *b) {
    const double kept = *a;
    *a = *b, *b = kept;
}

/* Bring row k of V for the longest from there on, and what belongs to it; return the square of its length. */
static double bring_longest(double *V, double *rhs, const double *square, size_t k, size_t n, size_t free, size_t width) {
    size_t pivot = k;
    for (size_t j = k + 1; j < n; j++)
        if (square[j] > square[pivot]) pivot = j;
    if (pivot != k) {
        swap(rhs + k, rhs + pivot);
        for (size_t i = 0; i < free; i++) swap(V + k * width + i, V + pivot * width + i);
    }
    return square[pivot];
}

static int triangulate(size_t n, size_t free, size_t width, double allowed, double *work) {
    double *V = work, *rhs = work + n * width, *factors = rhs + 2 * width;
    double *diagonal = factors + width, *square = diagonal + width, largest = 0.0;
    for (size_t j = 0; j < n; j++) {
        double s = 0.0;
        for (size_t i = 0; i < free; i++) s += V[j * width + i] * V[j * width + i];
        square[j] = s;
    }
    size_t rank = 0;
    for (size_t k = 0; k < (n < free ? n : free); k++) {
        const double norm = sqrt(bring_longest(V, rhs, square, k, n, free, width));
        if (k == 0) largest = norm;
        if (!(norm > RANK_TOLERANCE * largest)) break;
        double *v = V + k * width;
        const double alpha = v[k], beta = alpha >= 0.0 ? -norm : norm;
        v[k] = alpha - beta;
        const double factor = 1.0 / (norm * (norm + fabs(alpha)));
        factors[k] = factor;
        diagonal[k] = beta;
        for (size_t j = k + 1; j < n; j++) {
            double *row = V + j * width, s = 0.0, left = 0.0;
            for (size_t i = k; i < free; i++) s += v[i] * row[i];
            s *= factor;
            row[k] -= s * v[k];
            for (size_t i = k + 1; i < free; i++) {
                const double value = row[i] - s * v[i];
                row[i] = value;
                left += value * value;
            }
            square[j] = left;
        }
        rank++;
    }
    for (size_t j = 0; j < n; j++) {
        double s = rhs[j];
        for (size_t k = 0; k < (j < rank ? j : rank); k++) s -= V[j * width + k] * rhs[k];
        if (j < rank) {
            rhs[j] = s / diagonal[j];
            if (!(fabs(rhs[j]) < TOO_LARGE)) return -NOT_FOUND;
        } else if (!(fabs(s) <= allowed)) return -INFEASIBLE;
    }
    return (int)rank;
}

/* Write limits and locked tensions into the box and factors into `work`; the rank, or minus a status. */
static int factorise(const Problem *problem, size_t width, double *box, double *work, size_t *unlocked) {
    const size_t n = problem->n, m = problem->m;
    const double *W = problem->W, *low = problem->low, *high = problem->high;
    double *rhs = work + n * width, *cable = rhs + width, sound = 0.0, load = 0.0;
    size_t free = 0;
    for (size_t i = 0; i < m; i++) {
        if (!(low[i] <= high[i])) return -BAD_INPUT;
        box[i] = box[m + i] = low[i];
        box[2 * m + i] = high[i];
        if (low[i] < high[i]) cable[free++] = (double)i;
    }
    for (size_t j = 0; j < n; j++) {
        double s = problem->wrench[j];
        load = larger(load, fabs(s));
        for (size_t i = 0; i < m; i++) {
            sound += 0.0 * W[j * m + i];
            if (free < m && !(low[i] < high[i])) {
                s -= W[j * m + i] * low[i];
                load = larger(load, fabs(W[j * m + i] * low[i]));
            }
        }
        rhs[j] = s;
        sound += 0.0 * s;
        for (size_t k = 0; k < free; k++) work[j * width + k] = W[j * m + (size_t)cable[k]];
    }
    *unlocked = free;
    return sound == 0.0 ? triangulate(n, free, width, CONSISTENCY_TOLERANCE * load, work) : -BAD_INPUT;
}

/* Multiply y by the orthogonal factor. */
static void turn(size_t n, size_t free, size_t rank, size_t width, double *work) {
    const double *factors = work + (n + 2) * width;
    double *y = work + (n + 4) * width;
    for (size_t k = rank; k-- > 0;) {
        const double *v = work + k * width;
        double s = 0.0;
        for (size_t i = k; i < free; i++) s += v[i] * y[i];
        s *= factors[k];
        for (size_t i = k; i < free; i++) y[i] -= s * v[i];
    }
}

int tension_reduce(const Problem *problem, double *box, double *N, double *work) {
    const size_t n = problem->n, m = problem->m, width = width_of(n, m);
    const double *rhs = work + n * width, *cable = rhs + width;
    double *y = work + (n + 4) * width;
    size_t free = 0;
    const int found = factorise(problem, width, box, work, &free);
    if (found < 0) return found;
    const size_t rank = (size_t)found, r = free - rank;
    for (size_t i = 0; i < free; i++) y[i] = i < rank ? rhs[i] : 0.0;
    turn(n, free, rank, width, work);
    for (size_t i = 0; i < free; i++) box[(size_t)cable[i]] = y[i];
    memset(N, 0, m * m * sizeof *N);
    for (size_t unit = rank; unit < free; unit++) {
        memset(y, 0, free * sizeof *y);
        y[unit] = 1.0;
        turn(n, free, rank, width, work);
        for (size_t i = 0; i < free; i++) N[(size_t)cable[i] * m + unit - rank] = y[i];
    }
    for (size_t i = 0; i < m; i++) {
        double longest = 0.0;
        for (size_t k = 0; k < r; k++) longest = larger(longest, fabs(N[i * m + k]));
        if (longest <= ROUNDING) memset(N + i * m, 0, r * sizeof *N);
    }
    return (int)r;
}

int tension_settle(const Problem *problem, const double *box, double *tension) {
    const size_t n = problem->n, m = problem->m;
    double breach = 0.0, size = 0.0;
    for (size_t i = 0; i < m; i++) {
        const double beyond = larger(box[m + i] - tension[i], tension[i] - box[2 * m + i]);
        size = larger(size, fabs(tension[i]));
        breach = beyond <= breach || breach != breach ? breach : beyond;
    }
    if (!(breach <= VERTEX_TOLERANCE * size)) return INFEASIBLE;
    for (size_t i = 0; i < m; i++) tension[i] = smaller(larger(tension[i], box[m + i]), box[2 * m + i]);
    if (breach <= ROUND_OFF * size) return STATUS_OK;
    const double one = larger(1.0, LARGE * size);  /* N */
    for (size_t j = 0; j < n; j++) {
        double s = -problem->wrench[j], row = 0.0;
        for (size_t i = 0; i < m; i++) {
            s += problem->W[j * m + i] * tension[i];
            row = larger(row, fabs(problem->W[j * m + i]));
        }
        const double allowed = STRICTER * RESIDUAL_TOLERANCE * larger(fabs(problem->wrench[j]), one * smaller(row, 1.0));
        if (!(fabs(s) <= allowed)) return INFEASIBLE;
    }
    return STATUS_OK;
}

/* What is large beside the tolerances, N. */
static double newton(const Problem *problem) {
    double largest = 0.0;
    for (size_t i = 0; i < problem->m; i++)
        largest = larger(largest, larger(fabs(problem->low[i]), fabs(problem->high[i])));
    return largest >= 1.0 ? 1.0 : largest > 0.0 ? largest : 1.0;
}

/* Whether a finite answer keeps the limits and balances the wrench. */
static bool holds(const Problem *problem, const double *weights, const double *answer) {
    const size_t n = problem->n, m = problem->m;
    double unit = 1.0, square = 0.0, load = 0.0, margin = INFINITY;
    for (int turns = 0; turns < 2; turns++) {
        square = load = 0.0;
        for (size_t j = 0; j < n; j++) {
            double s = -problem->wrench[j];
            for (size_t i = 0; i < m; i++) s += problem->W[j * m + i] * answer[i];
            const double lack = unit * weights[j] * s, wanted = unit * weights[j] * problem->wrench[j];
            square += lack * lack;
            load += wanted * wanted;
        }
        if (square < INFINITY && load < INFINITY) break;
        unit = FAR;
    }
    const double one = newton(problem), tolerance = LIMIT_TOLERANCE * one;
    for (size_t i = 0; i < m; i++) {
        const double low = problem->low[i], high = problem->high[i];
        const double distance = smaller(answer[i] - low, high - answer[i]);
        if (!(low == high && distance >= -tolerance)) margin = smaller(margin, distance);
    }
    const double allowed = RESIDUAL_TOLERANCE * larger(one, sqrt(load) / unit);
    return margin >= -tolerance && sqrt(square) / unit <= allowed && allowed < INFINITY;
}

int tension_accept(const Problem *problem, const double *weights, const double *answer, double *tension) {
    for (size_t j = 0; j < problem->n; j++)
        if (!isfinite(problem->wrench[j])) return BAD_INPUT;
    for (size_t i = 0; i < problem->m; i++)
        if (!isfinite(answer[i])) return NOT_FOUND;
    if (!holds(problem, weights, answer)) return NOT_FOUND;
    for (size_t i = 0; i < problem->m; i++)
        tension[i] = smaller(larger(answer[i], problem->low[i]), problem->high[i]);
    return STATUS_OK;
}
