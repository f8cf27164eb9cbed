// The tensions nearest to a target where cables are many: Newton's method on the few equations, not the many cables.
// SPDX-License-Identifier: Apache-2.0
//
// The optimum is t(y) = target + B y, each cut off at its limits, for the y (k) with B^T t(y) = b, where B (m, k) spans
// the rows of W. So t(y) keeps the limits and all conditions of optimality but the equations, whatever y is. Newton's
// method with a line search solves these: they are the gradient of a concave function, piecewise quadratic, so that
// near the solution a step is exact (Qi and Sun, Mathematical Programming 58, 1993). Where there is none that function
// has no bound, along a direction that is the proof (Farkas). A step costs k^2 m instead of the (m - n) (2 m - n) of an
// active set in the null space, and there are fewer.
#pragma once

#include <cdpr/null_space.hpp>

namespace cdpr::CDPR_TARGET {

struct NearestByRows {
    const double* matrix;       // (n, m), W, moments in N m per N
    const double* wrench;       // (n), N and N m
    const double* tension_min;  // (m), N
    const double* tension_max;  // (m), N
    const double* target;       // (m), N
    double* tension;            // (m), N; without meaning unless the status is OK
    double* status;             // (1), a Status
    double* basis;              // (m, m), work space: B
    double* box;                // (4, m), work space
    double* factors;            // (n + 5, n + m), work space
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), target(m), tension(m), status(1), work basis(m, m), "
        "work box(4, m), work factors(n + 5, n + m), n, m";
};

namespace row_space {

// Allowed residual of the equations, as a share of the largest number in them: the round-off of a sum over many
// cables. Newton goes on as long as that shrinks.
constexpr double BALANCED = 1e-13;

// Below this it will not shrink any more.
constexpr double ROUND_OFF = 5e-16;

// A direction proves that no tensions balance the wrench if all together exert less along it than is wanted, by this
// share of what is summed up: far above the round-off, so that the proof holds.
constexpr double PROOF = 1e-9;

// So much of the direction's length may be missing from what a cable exerts along it, or be too much.
constexpr double DIRECTION_ERROR = 1e-14;

// Added to the eigenvalues of the Hessian, which lie between 0 and 1: zeros where fewer cables than equations are free.
constexpr double REGULARISATION = 1e-12;

// Ten steps are usual. What needs more is a set of admissible tensions that is as good as a point.
constexpr int MOST_STEPS = 40;

// How far a tension moves at most in the first trial of a line search, in largest tensions: beyond any limit, mostly.
constexpr double FAR = 10.0;

// A line search ends where the slope has fallen to this share.
constexpr double FLAT = 0.1;

// Trials of a line search: a few are usual, and a fourfold step each time has then gone beyond all numbers.
constexpr int MOST_TRIALS = 60;

// The work space, in that of `factorise`.
struct Equations {
    Matrix<const double> B;  // (m, k), orthonormal columns
    const double* low;       // (m), N
    const double* high;      // (m), N
    double* tension;         // (m), N, t(y)
    Matrix<double> G;        // (k, k), lower half: how B^T t(y) changes with y, then its factor
    double* b;               // (k), what is wanted
    double* y;               // (k)
    double* d;               // (k), direction in which y moves
    double* left;            // (k), b - B^T t(y)
    double* offset;          // (m), target + B y
    double* rate;            // (m), how that changes along d
    int64_t k, m;

    CDPR_INLINE bool free(int64_t i) const { return low[i] < high[i]; }
};

CDPR_INLINE Equations equations_of(const TensionProblem<double>& p, int64_t k) {
    const Matrix<double> work = p.work_rows(), rest = work.from(k);
    return {{p.basis, p.m}, p.tension_min, p.tension_max, p.tension,  work, rest[0], rest[1],
            rest[2],        rest[3],       rest[4],       p.center(), k,    p.m};
}

// Start at the solution of least distance, without limits.
CDPR_INLINE void start(const TensionProblem<double>& p, const Equations& e) {
    const double *c = p.center(), *target = p.target();
    for (int64_t j = 0; j < e.k; j++) {
        e.b[j] = sum(0.0, 0, e.m, [&](int64_t i) { return e.B(i, j) * c[i]; });
        e.y[j] = sum(0.0, 0, e.m, [&](int64_t i) { return e.B(i, j) * (c[i] - target[i]); });
    }
    for (int64_t i = 0; i < e.m; i++)
        e.offset[i] = sum(target[i], 0, e.k, [&](int64_t j) { return e.B(i, j) * e.y[j]; });
}

// Largest residual of the equations, and the largest number in them.
struct Lack {
    double most, size;
};

// Write t(y), what the equations lack, and how they change with y through the cables that are within their limits.
CDPR_INLINE Lack evaluate(const Equations& e) {
    Lack lack = {0.0, 0.0};
    for (int64_t j = 0; j < e.k; j++) {
        e.left[j] = e.b[j];
        for (int64_t q = 0; q <= j; q++) e.G(j, q) = 0.0;
        e.G(j, j) = REGULARISATION;
    }
    for (int64_t i = 0; i < e.m; i++) {
        const double t = smaller(larger(e.offset[i], e.low[i]), e.high[i]);
        e.tension[i] = t;
        lack.size = larger(lack.size, absolute(t));
        if (e.free(i))
            for (int64_t j = 0; j < e.k; j++) e.left[j] -= e.B(i, j) * t;
        if (e.low[i] < e.offset[i] && e.offset[i] < e.high[i])
            for (int64_t j = 0; j < e.k; j++)
                for (int64_t q = 0; q <= j; q++) e.G(j, q) += e.B(i, j) * e.B(i, q);
    }
    for (int64_t j = 0; j < e.k; j++) {
        lack.most = larger(lack.most, absolute(e.left[j]));
        lack.size = larger(lack.size, absolute(e.b[j]));
    }
    return lack;
}

// Write d: G d = left. G becomes its Cholesky factor.
CDPR_INLINE void newton_step(const Equations& e) {
    const Matrix<double> G = e.G;
    for (int64_t j = 0; j < e.k; j++)
        for (int64_t q = 0; q <= j; q++) {
            const double s = difference(G(j, q), 0, q, [&](int64_t p) { return G(j, p) * G(q, p); });
            G(j, q) = q == j ? square_root(larger(s, REGULARISATION)) : s / G(q, q);
        }
    for (int64_t j = 0; j < e.k; j++)
        e.d[j] = difference(e.left[j], 0, j, [&](int64_t p) { return G(j, p) * e.d[p]; }) / G(j, j);
    for (int64_t j = e.k - 1; j >= 0; j--)
        e.d[j] = difference(e.d[j], j + 1, e.k, [&](int64_t p) { return G(p, j) * e.d[p]; }) / G(j, j);
}

// Along d: the slope at y, what is wanted, and how fast the fastest tension changes.
struct Direction {
    double slope, wanted, fastest;
    bool proof;  // all cables together exert less than that
};

// Write the rates along d.
CDPR_INLINE Direction look_along(const Equations& e) {
    double slope = 0.0, wanted = 0.0, reach = 0.0, total = 0.0, fastest = 0.0, error = 0.0;
    for (int64_t j = 0; j < e.k; j++) {
        slope += e.d[j] * e.left[j];
        wanted += e.d[j] * e.b[j];
        total += absolute(e.d[j] * e.b[j]);
        error += DIRECTION_ERROR * absolute(e.d[j]);
    }
    for (int64_t i = 0; i < e.m; i++) {
        const double s = sum(0.0, 0, e.k, [&](int64_t j) { return e.B(i, j) * e.d[j]; });
        e.rate[i] = s;
        fastest = larger(fastest, absolute(s));
        if (!e.free(i)) continue;
        const double more = s + error, less = s - error, low = e.low[i], high = e.high[i];
        const double most = larger(larger(larger(more * high, more * low), less * high), less * low);
        reach += most;
        total += absolute(most);
    }
    return {slope, wanted, fastest, wanted - reach > PROOF * total};
}

// Return a step > 0, the given one if it will do, where the slope, `start` > 0 at 0, has fallen to about zero; -1 where
// there is none within reach. The slope is `wanted` less what the cables exert along the direction.
CDPR_INLINE double line_search(const Equations& e, double step, double wanted, double start) {
    double near = 0.0, far = INFINITE, slope_near = start, slope_far = 0.0;
    for (int trial = 0; trial < MOST_TRIALS; trial++) {
        double slope = wanted;
        for (int64_t i = 0; i < e.m; i++)
            if (e.free(i)) slope -= e.rate[i] * smaller(larger(e.offset[i] + step * e.rate[i], e.low[i]), e.high[i]);
        if (absolute(slope) <= FLAT * start) return step;
        if (slope > 0.0) {
            near = step;
            slope_near = slope;
        } else {
            far = step;
            slope_far = slope;
        }
        if (far == INFINITE) {
            step *= 4.0;
        } else {
            // The secant, kept off the ends so that the interval shrinks.
            const double share = slope_near / (slope_near - slope_far);
            step = near + smaller(larger(share, 0.1), 0.9) * (far - near);
        }
    }
    return -1.0;
}

// Write the tensions nearest to the target, in the box. Return OK or INFEASIBLE, which are proved; BAD_INPUT as
// `reduce`; or NOT_FOUND, which leaves the question to null_space.hpp and active_set.hpp, as where the admissible
// tensions are as good as a point.
inline int nearest_by_rows(const TensionProblem<double>& problem) {
    const int64_t k = reduce_to_rows(problem);
    if (k < 0) return int(-k);
    const Equations e = equations_of(problem, k);
    start(problem, e);
    double before = INFINITE;
    for (int trial = 0; trial < MOST_STEPS; trial++) {
        const Lack lack = evaluate(e);
        const bool close = lack.most <= BALANCED * lack.size;
        if (lack.most <= ROUND_OFF * lack.size || (close && lack.most > 0.5 * before)) return OK;
        if (!(lack.most < INFINITE)) return NOT_FOUND;
        before = lack.most;
        newton_step(e);
        const Direction along = look_along(e);
        if (along.proof) return INFEASIBLE;
        double step = 1.0;
        if (!close) {  // where a line search would look at round-off
            // With fewer cables free than equations Newton's step is far too long.
            const double first = smaller(1.0, FAR * lack.size / along.fastest);
            step = line_search(e, first, along.wanted, along.slope);
        }
        if (step < 0.0) return NOT_FOUND;
        for (int64_t i = 0; i < e.m; i++) e.offset[i] += step * e.rate[i];
    }
    return NOT_FOUND;
}

}  // namespace row_space

using row_space::nearest_by_rows;

// Return whether the rows of W (n, m) are fewer than the dimensions of its null space.
CDPR_INLINE bool many_cables(int64_t n, int64_t m) { return m - n > n; }

// The same as an operation.
inline int nearest_tension_by_rows(NearestByRows& p) {
    const TensionProblem<double> problem = {p.matrix, p.wrench, p.tension_min, p.tension_max, p.tension, p.status,
                                            p.basis,  p.box,    p.factors,     p.n,           p.m};
    for (int64_t i = 0; i < p.m; i++) problem.target()[i] = p.target[i];
    const int status = nearest_by_rows(problem);
    *p.status = status;
    return status;
}

}  // namespace cdpr::CDPR_TARGET
