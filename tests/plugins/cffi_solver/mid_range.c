// Tensions nearest to the middle of their limits, by orthogonal rows of W (modified Gram-Schmidt).
#include <stdint.h>

enum { OK = 0, NOT_FOUND = 2, BAD_INPUT = 4 };
static const double DEPENDENT = 1e-18; // of a row's square: what is left of one that depends on those before
static const double ROUND_OFF = 1e-12; // of the wrench and the tensions: what such a row may miss

struct place {
    const double *matrix, *wrench, *low, *high; // (n, m), (n), (m), (m)
    double *tension;                            // (m)
    int64_t n, m;
    double *rows;  // (n, m), work space
    double *share; // (n), work space
};

static double dot(const double *a, const double *b, int64_t m) {
    double sum = 0.0;
    for (int64_t i = 0; i < m; i++) sum += a[i] * b[i];
    return sum;
}

static int mid_range(void *place, double time) {
    const struct place *p = place;
    const int64_t n = p->n, m = p->m;
    double *t = p->tension, scale = 0.0;
    for (int64_t i = 0; i < m; i++) t[i] = 0.5 * (p->low[i] + p->high[i]);
    for (int64_t i = 0; i < m; i++) scale += t[i] < 0.0 ? -t[i] : t[i];
    for (int64_t k = 0; k < n; k++) scale += p->wrench[k] < 0.0 ? -p->wrench[k] : p->wrench[k];
    for (int64_t k = 0; k < n; k++) p->share[k] = p->wrench[k] - dot(p->matrix + k * m, t, m);
    for (int64_t k = 0; k < n; k++) {
        double *row = p->rows + k * m;
        for (int64_t i = 0; i < m; i++) row[i] = p->matrix[k * m + i];
        const double whole = dot(row, row, m);
        for (int64_t j = 0; j < k; j++) {
            const double *before = p->rows + j * m;
            const double along = dot(row, before, m);
            for (int64_t i = 0; i < m; i++) row[i] -= along * before[i];
            p->share[k] -= along * p->share[j];
        }
        const double left = dot(row, row, m);
        if (!(whole - whole == 0.0 && p->share[k] - p->share[k] == 0.0)) return BAD_INPUT;
        if (left <= DEPENDENT * whole) {
            if (p->share[k] > ROUND_OFF * scale || -p->share[k] > ROUND_OFF * scale) return NOT_FOUND;
            for (int64_t i = 0; i < m; i++) row[i] = 0.0;
            continue;
        }
        const double length = __builtin_sqrt(left);
        for (int64_t i = 0; i < m; i++) row[i] /= length;
        p->share[k] /= length;
        for (int64_t i = 0; i < m; i++) t[i] += p->share[k] * row[i];
    }
    (void)time;
    for (int64_t i = 0; i < m; i++)
        if (!(p->low[i] <= t[i] && t[i] <= p->high[i])) return NOT_FOUND;
    return OK;
}
