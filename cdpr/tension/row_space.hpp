// Tensions nearest to a target for robots with many cables: Newton's method on the few equations, not the many cables.
// SPDX-License-Identifier: Apache-2.0
//
// The optimum is t(y) = target + B y, clipped to the limits, for the y (k) with B^T t(y) = b, where B (m, k) spans the
// rows of W. For any y, t(y) satisfies the limits and all optimality conditions except the equations. Newton's method
// with a line search solves these: they are the gradient of a concave, piecewise quadratic function, so that a step
// near the solution is exact (Qi and Sun, Mathematical Programming 58, 1993). Without a solution that function is
// unbounded along a direction, which is the proof (Farkas). A step costs k^2 m instead of the (m - n) (2 m - n) of an
// active set in the null space, and fewer steps are needed.
#pragma once

#include <cdpr/tension/null_space.hpp>

namespace cdpr::CDPR_TARGET {

struct NearestByRows {
    const double* matrix;       // (n, m), W, moments in N m per N
    const double* wrench;       // (n), N and N m
    const double* tension_min;  // (m), N
    const double* tension_max;  // (m), N
    const double* target;       // (m), N
    double* tension;            // (m), N; undefined unless the status is OK
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

// Allowed residual of the equations, as a share of the largest number in them: the round-off of a sum over many cables.
// The iteration continues as long as the residual shrinks.
constexpr double BALANCED = 1e-13;

// Below this the residual does not shrink any more.
constexpr double ROUND_OFF = 5e-16;

// A direction proves infeasibility if all cables together exert less along it than required, by this share of the sum
// of absolute values: far above the round-off, so that the proof is valid.
constexpr double PROOF = 1e-9;

// Relative error of a cable's force along the direction, relative to the direction's length.
constexpr double DIRECTION_ERROR = 1e-14;

// Added to the eigenvalues of the Hessian, which lie between 0 and 1: zeros if fewer cables than equations are free.
constexpr double REGULARISATION = 1e-12;

// Ten steps are typical. Problems that need more have admissible tensions that are practically a point.
constexpr int MOST_STEPS = 40;

// Largest change of a tension in the first trial of a line search, in largest tensions: usually beyond any limit.
constexpr double FAR = 10.0;

// A line search ends when the slope has fallen to this share.
constexpr double FLAT = 0.1;

// Trials of a line search: a few are typical; this many fourfold steps exceed the range of numbers.
constexpr int MOST_TRIALS = 60;

// Work space, in that of `factorise`.
struct Equations {
    Matrix<const double> B;  // (m, k), orthonormal columns
    const double* low;       // (m), N
    const double* high;      // (m), N
    double* tension;         // (m), N, t(y)
    Matrix<double> G;        // (k, k), lower half: derivative of B^T t(y) by y, then its factor
    double* b;               // (k), right-hand side
    double* y;               // (k)
    double* d;               // (k), direction of y
    double* left;            // (k), b - B^T t(y)
    double* offset;          // (m), target + B y
    double* rate;            // (m), its rate along d
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

// Write t(y), the residual, and the derivative by y through the cables within their limits.
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

// Along d: the slope at y, the required value, and the rate of the fastest tension.
struct Direction {
    double slope, wanted, fastest;
    bool proof;  // all cables together exert less: infeasible
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

// Return a step > 0, if possible the given one, at which the slope, `start` > 0 at 0, has fallen to about zero; -1 if
// there is none within range. The slope is `wanted` less the force of the cables along the direction.
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
            // Secant, kept away from the ends so that the interval shrinks.
            const double share = slope_near / (slope_near - slope_far);
            step = near + smaller(larger(share, 0.1), 0.9) * (far - near);
        }
    }
    return -1.0;
}

// Write the tensions nearest to the target, in the box. Return OK or INFEASIBLE, both proved; BAD_INPUT as `reduce`; or
// NOT_FOUND, which leaves the decision to null_space.hpp and active_set.hpp, for example if the admissible tensions are
// practically a point.
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
        if (!close) {  // a line search would only see round-off
            // With fewer free cables than equations Newton's step is far too long.
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
