// Tensions within the limits with the wrench nearest to a required one, for problems without an admissible
// distribution. SPDX-License-Identifier: Apache-2.0
//
// min |D (W t - wrench)| with t_min <= t <= t_max, D = diag(weights); the solution of least norm if there are several.
// Any n, m and rank; upper limits may be infinite. The feasible wrenches form a convex set, so the nearest W t is
// unique and depends continuously on the required wrench; so do its tensions of least norm. They equal the distribution
// of least norm if that exists: nothing jumps when a wrench becomes infeasible.
#pragma once

#include <cdpr/tension/active_set.hpp>
#include <cdpr/tension/null_space.hpp>
#include <cdpr/tension/row_space.hpp>

namespace cdpr::CDPR_TARGET {

// Work space of the search.
struct BoxLeastSquaresSpace {
    double* basis;    // (m, m): N
    double* box;      // (4, m): a solution, the limits, a target
    double* factors;  // (n + 5, n + m)
    double* search;   // (2 m + 8, m): active set
    double* vectors;  // (3, m): x, which limits are active, the least tensions
    double* reached;  // (n): the nearest wrench
    double* table;    // (3 n + 8, n + m): factors of the free cables
    static constexpr char fields[] =
        "work basis(m, m), work box(4, m), work factors(n + 5, n + m), work search(2*m + 8, m), work vectors(3, m), "
        "work reached(n), work table(3*n + 8, n + m)";
};

struct BoxLeastSquares {
    const double* matrix;       // (n, m), W, moments in N m per N
    const double* wrench;       // (n), N and N m
    const double* tension_min;  // (m), N
    const double* tension_max;  // (m), N
    const double* weights;      // (n): 1 for forces and 1 / characteristic length, 1/m, for moments
    double* tension;            // (m), N; unchanged if a lower limit is infinite
    double* status;             // (1), a Status
    double* steps;              // (1), number of steps
    BoxLeastSquaresSpace space;
    int64_t n;
    int64_t m;
    static constexpr auto fields = join(
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), weights(n), both tension(m), status(1), steps(1), ",
        BoxLeastSquaresSpace::fields, ", n, m");

    CDPR_INLINE double* x() const { return space.vectors; }
    CDPR_INLINE double* active() const { return space.vectors + m; }
    CDPR_INLINE double* least() const { return space.vectors + 2 * m; }

    // Problem of least norm for a wrench.
    CDPR_INLINE TensionProblem<double> problem(const double* wanted, double* answer) const {
        return {matrix, wanted, tension_min, tension_max, answer, status, space.basis, space.box, space.factors, n, m};
    }
};

namespace bounded {

// A cable at a limit is not released if this reduces the squared residual by less than this share of the largest
// possible change: round-off.
constexpr double GRADIENT_TOLERANCE = 1e-12;

// A cable is at its limit in all solutions if releasing it would increase the squared residual by more than this share
// of the largest possible change.
constexpr double PRESSED = 1e-9;

// A cable depends on the free cables if its remaining effect is below this share of its length.
constexpr double DEPENDENCE = 1e-9;

// Cables between their limits, k of them: their columns of D W are J[:, :k] R.
struct FreeCables {
    Matrix<double> A;   // (n, m), D W
    Matrix<double> J;   // (n, n)
    Matrix<double> R;   // (n, n)
    double* residual;   // (n), D (wrench - W t)
    double* d;          // (n)
    double* goal;       // (n), least-squares tensions of the free cables
    double* member;     // (n), the number of each free cable
    double* projected;  // (n)
    double* place;      // (m), -1 and 1: at a limit; 0: free
    double* size;       // (m), lengths of the columns of A
    double* barred;     // (m), cables that may not be released at present
    int64_t n, m, k;
};

CDPR_INLINE FreeCables free_cables(const BoxLeastSquares& p) {
    const int64_t n = p.n;
    const Matrix<double> table = {p.space.table, n + p.m}, rest = table.from(3 * n);
    return {table,   table.from(n), table.from(2 * n), rest[0], rest[1], rest[2], rest[3],
            rest[4], rest[5],       rest[6],           rest[7], n,       p.m,     0};
}

// All cables at their lower limits.
CDPR_INLINE void start(const BoxLeastSquares& p, const FreeCables& f) {
    set_identity(f.J, f.n);
    for (int64_t j = 0; j < f.n; j++)
        for (int64_t i = 0; i < f.m; i++) f.A(j, i) = p.weights[j] * p.matrix[j * f.m + i];
    for (int64_t i = 0; i < f.m; i++) {
        f.size[i] = square_root(sum(0.0, 0, f.n, [&](int64_t j) { return f.A(j, i) * f.A(j, i); }));
        f.place[i] = -1.0;
        f.barred[i] = 0.0;
        p.tension[i] = p.tension_min[i];
    }
}

// Write the residual; return the sum of the absolute values of its terms.
CDPR_INLINE double write_residual(const BoxLeastSquares& p, const FreeCables& f) {
    double total = 0.0;
    for (int64_t j = 0; j < f.n; j++) {
        double s = p.weights[j] * p.wrench[j];
        total += absolute(s);
        for (int64_t i = 0; i < f.m; i++) {
            const double part = f.A(j, i) * p.tension[i];
            s -= part;
            total += absolute(part);
        }
        f.residual[j] = s;
    }
    return total;
}

// Next cable to release, -1 for none, and whether the solution is then unique.
struct Entering {
    int64_t cable;
    bool unique = false;
};

// Choose the cable at a limit whose release reduces the residual most.
CDPR_INLINE Entering choose_entering(const BoxLeastSquares& p, const FreeCables& f, double total) {
    Entering found = {-1, true};
    double best = GRADIENT_TOLERANCE * total;
    for (int64_t i = 0; i < f.m; i++) {
        if (f.place[i] == 0.0 || !(p.tension_min[i] < p.tension_max[i])) continue;
        const double s = sum(0.0, 0, f.n, [&](int64_t j) { return f.A(j, i) * f.residual[j]; });
        // All solutions have the same residual: a cable that it presses against its limit is at that limit in all.
        if (!(f.place[i] * s > PRESSED * total * f.size[i])) found.unique = false;
        if (f.barred[i] == 0.0 && -f.place[i] * s > best * f.size[i]) {
            found.cable = i;
            best = -f.place[i] * s / f.size[i];
        }
    }
    return found;
}

// Release a cable; return false if it depends on the free ones.
CDPR_INLINE bool enter(FreeCables& f, int64_t cable) {
    for (int64_t j = 0; j < f.n; j++) f.d[j] = sum(0.0, 0, f.n, [&](int64_t i) { return f.J(i, j) * f.A(i, cable); });
    const double square = sum(0.0, f.k, f.n, [&](int64_t j) { return f.d[j] * f.d[j]; });
    const double shortest = DEPENDENCE * f.size[cable];
    if (!(square > shortest * shortest)) return false;
    append(f.J, f.R, f.d, f.n, f.k);
    f.member[f.k] = double(cable);
    f.place[cable] = 0.0;
    f.k++;
    return true;
}

// Write least squares over the free cables: R goal = J^T (wrench not exerted by the others).
CDPR_INLINE void write_goal(const BoxLeastSquares& p, const FreeCables& f) {
    for (int64_t j = 0; j < f.n; j++) {
        double s = p.weights[j] * p.wrench[j];
        for (int64_t i = 0; i < f.m; i++)
            if (f.place[i] != 0.0) s -= f.A(j, i) * p.tension[i];
        f.d[j] = s;
    }
    for (int64_t j = 0; j < f.k; j++) f.projected[j] = sum(0.0, 0, f.n, [&](int64_t i) { return f.J(i, j) * f.d[i]; });
    back_substitute(f.R, f.projected, f.goal, f.k);
}

// Move the free cables towards the goal until one reaches a limit, which holds it; return whether none does.
CDPR_INLINE bool approach(const BoxLeastSquares& p, FreeCables& f) {
    double step = 1.0, wall = 0.0;
    int64_t blocked = -1;
    for (int64_t j = 0; j < f.k; j++) {
        const int64_t i = whole(f.member[j]);
        const double low = p.tension_min[i], high = p.tension_max[i], t = p.tension[i], move = f.goal[j] - t;
        if (f.goal[j] < low && low - t > step * move) {
            step = (low - t) / move;
            blocked = j;
            wall = -1.0;
        } else if (f.goal[j] > high && high - t < step * move) {
            step = (high - t) / move;
            blocked = j;
            wall = 1.0;
        }
    }
    for (int64_t j = 0; j < f.k; j++) {
        double* t = p.tension + whole(f.member[j]);
        *t += larger(step, 0.0) * (f.goal[j] - *t);
    }
    if (blocked < 0) return true;
    const int64_t i = whole(f.member[blocked]);
    f.place[i] = wall;
    p.tension[i] = wall < 0.0 ? p.tension_min[i] : p.tension_max[i];
    remove(f.J, f.R, f.projected, f.member, f.n, f.k, blocked);
    f.k--;
    return false;
}

// Move to the least squares over the free cables after releasing `entered` from a limit at `side`. Return whether any
// tension changed. If round-off would move it in the wrong direction, the cable returns to its limit.
CDPR_INLINE bool descend(const BoxLeastSquares& p, FreeCables& f, int64_t entered, double side) {
    bool moved = false;
    while (f.k > 0) {
        write_goal(p, f);
        if (!moved && side * (f.goal[f.k - 1] - p.tension[entered]) >= 0.0) {
            f.barred[entered] = 1.0;
            f.place[entered] = side;
            f.k--;
            return false;
        }
        moved = true;
        if (approach(p, f)) break;
    }
    return moved;
}

// Write tensions that minimise the residual; return the number of steps, or -NOT_FOUND, and whether they are unique.
//
// Stark and Parker, Computational Statistics 10 (1995), BVLS: cables are released one by one if that reduces the
// residual, and return to a limit if least squares over the free cables would exceed it.
inline int64_t nearest_wrench(const BoxLeastSquares& p, bool& unique) {
    FreeCables f = free_cables(p);
    start(p, f);
    for (int64_t steps = 0; steps < 20 * (f.m + 1); steps++) {
        const Entering entering = choose_entering(p, f, write_residual(p, f));
        const int64_t i = entering.cable;
        unique = entering.unique;
        if (i < 0) return steps;
        const double side = f.place[i];
        if (!enter(f, i))
            f.barred[i] = 1.0;
        else if (descend(p, f, i, side))
            for (int64_t other = 0; other < f.m; other++) f.barred[other] = 0.0;
    }
    unique = false;
    return -NOT_FOUND;
}

// Replace the tensions by the least ones with the same wrench; return the number of steps.
inline int64_t lessen(const BoxLeastSquares& p) {
    for (int64_t j = 0; j < p.n; j++)
        p.space.reached[j] = sum(0.0, 0, p.m, [&](int64_t i) { return p.matrix[j * p.m + i] * p.tension[i]; });
    const TensionProblem<double> problem = p.problem(p.space.reached, p.least());
    int64_t steps = 0;
    bool found = false;
    if (many_cables(p.n, p.m)) {
        for (int64_t i = 0; i < p.m; i++) problem.target()[i] = 0.0;
        found = nearest_by_rows(problem) == OK;
    }
    if (!found) {
        const int64_t r = reduce_once(problem);
        if (r < 0) return 0;
        ActiveSet set = active_set(p.space.search, p.m, r);
        steps = nearest(polytope_of(problem, r, p.x(), p.active()), set);
        if (steps < 0) return 0;
    }
    for (int64_t i = 0; i < p.m; i++) p.tension[i] = p.least()[i];
    return steps;
}

// Write the tensions; return the number of steps, -NOT_FOUND if the iteration fails, or -UNSUPPORTED, with unchanged
// tensions, if a lower limit is infinite.
inline int64_t find(const BoxLeastSquares& p) {
    for (int64_t i = 0; i < p.m; i++)
        if (p.tension_min[i] == -INFINITE) return -UNSUPPORTED;
    bool unique = false;
    const int64_t steps = nearest_wrench(p, unique);
    return steps < 0 || unique ? steps : steps + lessen(p);
}

}  // namespace bounded

// Write the tensions and the number of steps; return and write the status: OK, NOT_FOUND, or UNSUPPORTED if a lower
// limit is infinite.
inline int box_least_squares(BoxLeastSquares& p) {
    const int64_t steps = bounded::find(p);
    const int status = steps < 0 ? int(-steps) : int(OK);
    *p.steps = steps < 0 ? 0.0 : double(steps);
    *p.status = status;
    return status;
}

}  // namespace cdpr::CDPR_TARGET
