// Distribution of least 2-norm within the limits, or nearest to a reference. SPDX-License-Identifier: Apache-2.0
//
// min sum w_i (t_i - ref_i)^2 with W t = wrench, t_min <= t <= t_max: a convex quadratic program (Bruckmann et al.
// 2006). With t = c + N x the optimum is the point of least norm in a polytope. A reference moves the origin to N^T
// ref; weights scale the cables: with D = diag(sqrt(w)), D t solves the problem of W D^-1.
#pragma once

#include <cdpr/alone.hpp>
#include <cdpr/tension/active_set.hpp>
#include <cdpr/tension/null_space.hpp>
#include <cdpr/tension/row_space.hpp>

namespace cdpr::CDPR_TARGET {

// Target of the tensions.
enum About { ZERO, MIDDLE, PREVIOUS, GIVEN };

// The round-off of a reference this many times as large as the tensions matters (2^-52 of it, compared with the allowed
// residual). For a nearer reference it does not, and a failed search proves infeasibility.
constexpr double FAR_REFERENCE = 1e3;

template <class T> struct MinimumNorm {
    const T* matrix;       // (n, m), W, moments in N m per N
    const T* wrench;       // (n), N and N m
    const T* tension_min;  // (m), N
    const T* tension_max;  // (m), N
    const T* reference;    // (m), N, for GIVEN
    const T* root;         // (m), roots of the weights, if `weighted`
    T* tension;            // (m), N, of the previous step, NaN if there is none, then the answer
    T* status;             // (1), a Status
    T* basis;              // (m, m), work space: N
    T* box;                // (4, m), work space: a solution, the limits, a target
    T* factors;            // (n + 5, n + m), work space
    T* search;             // (2 m + 8, m), work space: active set
    T* vectors;            // (2, m), work space: x, and which limits are active
    T* scaled;             // (n + 2, m), work space: W and the limits, scaled by the weights
    double change;         // N, largest change of a tension in a step; may be infinite
    int64_t about;         // About
    int64_t weighted;      // whether there are weights
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), reference(m), root(m), both tension(m), status(1), "
        "work basis(m, m), work box(4, m), work factors(n + 5, n + m), work search(2*m + 8, m), work vectors(2, m), "
        "work scaled(n + 2, m), change, about, weighted, n, m";

    CDPR_INLINE T* x() const { return vectors; }
    CDPR_INLINE T* active() const { return vectors + m; }
    CDPR_INLINE T* target() const { return box + 3 * m; }
    CDPR_INLINE T* low() const { return scaled + n * m; }
    CDPR_INLINE T* high() const { return scaled + (n + 1) * m; }

    CDPR_INLINE TensionProblem<T> problem() const {
        return {matrix, wrench, tension_min, tension_max, tension, status, basis, box, factors, n, m};
    }
    CDPR_INLINE TensionProblem<T> scaled_problem() const {
        return {scaled, wrench, low(), high(), tension, status, basis, box, factors, n, m};
    }
};

// Return whether all tensions of the previous step are known.
template <class T> CDPR_INLINE Truth<T> follows(const MinimumNorm<T>& p) {
    Truth<T> known = true;
    for (int64_t i = 0; i < p.m; i++) known = known & finite(p.tension[i]);
    return known;
}

// Variant of a problem. The first step has no previous one: its target is zero and any change is allowed.
struct Question {
    int64_t about;
    bool window;  // whether changes of tensions are limited to p.change
    bool plain;   // least norm within the limits only
};

CDPR_INLINE Question question_of(const MinimumNorm<double>& p) {
    int64_t about = p.about;
    bool window = finite(p.change);
    if ((about == PREVIOUS || window) && !follows(p)) {
        if (about == PREVIOUS) about = ZERO;
        window = false;
    }
    return {about, window, !(p.weighted || window || about != ZERO || many_cables(p.n, p.m))};
}

// Write W, the limits and the target, scaled by the weights, with the limits narrowed to the window. Return a status.
CDPR_INLINE int scale(const MinimumNorm<double>& p, const Question& asked) {
    double *low = p.low(), *high = p.high(), *target = p.target();
    for (int64_t i = 0; i < p.m; i++) {
        const double s = p.weighted ? p.root[i] : 1.0, t = p.tension[i];
        low[i] = s * p.tension_min[i];
        high[i] = s * p.tension_max[i];
        target[i] = 0.0;
        if (asked.about == MIDDLE) {
            target[i] = s * (0.5 * (p.tension_min[i] + p.tension_max[i]));
            if (!finite(target[i])) return UNSUPPORTED;
        } else if (asked.about != ZERO) {
            target[i] = s * (asked.about == PREVIOUS ? t : p.reference[i]);
        }
        if (asked.window) {
            if (!(p.tension_min[i] <= p.tension_max[i])) return BAD_INPUT;
            low[i] = larger(low[i], s * (t - p.change));
            high[i] = smaller(high[i], s * (t + p.change));
            if (!(low[i] <= high[i])) return NOT_FOUND;  // the limits themselves have moved away
        }
        for (int64_t j = 0; j < p.n; j++) {
            const double entry = p.matrix[j * p.m + i];
            p.scaled[j * p.m + i] = p.weighted ? entry / s : entry;
        }
    }
    return OK;
}

// Move the origin of x to the target: c becomes the solution nearest to it.
CDPR_INLINE void move_origin(const MinimumNorm<double>& p, int64_t r) {
    const Matrix<double> N = {p.basis, p.m};
    for (int64_t k = 0; k < r; k++) p.x()[k] = sum(0.0, 0, p.m, [&](int64_t i) { return N(i, k) * p.target()[i]; });
    for (int64_t i = 0; i < p.m; i++) p.box[i] = sum(p.box[i], 0, r, [&](int64_t k) { return N(i, k) * p.x()[k]; });
}

// Convert the result of the scaled problem back to newtons.
CDPR_INLINE void unscale(const MinimumNorm<double>& p, int64_t r) {
    for (int64_t i = 0; i < p.m; i++) {
        p.tension[i] = smaller(larger(p.tension[i] / p.root[i], p.tension_min[i]), p.tension_max[i]);
        p.box[i] /= p.root[i];
        for (int64_t k = 0; k < r; k++) p.basis[i * p.m + k] /= p.root[i];
    }
}

// Result of a trial: the status, and whether it is final.
struct Trial {
    int status;
    bool found, last;
};

// Solve in null-space form.
inline Trial try_null_space(const MinimumNorm<double>& p, const Question& asked) {
    const TensionProblem<double> problem = p.problem(), reduced = asked.plain ? problem : p.scaled_problem();
    Factors<double> f = factors_of(reduced);
    const int64_t r = reduce_to_point(reduced, f);
    if (r < 0) return {asked.window && r == -INFEASIBLE ? NOT_FOUND : int(-r), false, true};
    const Polytope<double> polytope = polytope_of(reduced, r, p.x(), p.active());
    if (asked.plain) {
        const Excess<double> reach = least(polytope);
        if (reach.most <= FEASIBILITY_TOLERANCE * reach.scale)  // the usual case: no limit is active, and N not needed
            return {int(verdict(problem, 0, p.x())), true, true};
    }
    complete(reduced, f);
    if (asked.about != ZERO) move_origin(p, r);
    ActiveSet set = active_set(p.search, p.m, r);
    const int64_t steps = nearest(polytope, set);
    if (steps < 0) return {int(-steps), false, false};
    if (p.weighted) unscale(p, r);
    return {int(verdict(problem, r, p.x())), true, false};
}

// Solve in the row space for many cables; else, or without a decision there, in null-space form.
CDPR_INLINE Trial attempt(const MinimumNorm<double>& p, const Question& asked) {
    if (many_cables(p.n, p.m)) {
        const int status = nearest_by_rows(p.scaled_problem());
        if (status == OK && p.weighted) unscale(p, 0);
        if (status != NOT_FOUND) return {status, status == OK, false};
    }
    return try_null_space(p, asked);
}

// Return the status of the written tensions.
CDPR_INLINE int find_minimum(const MinimumNorm<double>& p, const Question& asked) {
    if (!asked.plain) {
        const int status = scale(p, asked);
        if (status != OK) return status;
    }
    Trial trial = attempt(p, asked);
    if (trial.last || asked.about == ZERO || !(trial.status == INFEASIBLE || trial.status == NOT_FOUND))
        return trial.status;
    // The round-off of a target far from the limits, such as the middle of practically infinite ones, may be as large
    // as the tensions. A second problem with the result as its target removes it.
    const int lost = trial.found ? OK : trial.status;
    double far = 0.0, size = 0.0;
    for (int64_t i = 0; i < p.m; i++) {
        const double s = p.weighted ? p.root[i] : 1.0;
        far = larger(far, absolute(p.target()[i]) / s);
        p.target()[i] = trial.found ? s * p.tension[i] : 0.0;
    }
    trial = attempt(p, asked);
    if (trial.last || lost == OK || trial.status != OK) return trial.status;
    for (int64_t i = 0; i < p.m; i++) size = larger(size, absolute(p.tension[i]));
    return far > FAR_REFERENCE * size ? NOT_FOUND : lost;  // there are some, but the nearest ones are lost to round-off
}

// Write the distribution nearest to the reference; return OK, INFEASIBLE, BAD_INPUT, UNSUPPORTED for the middle of
// infinite limits, or NOT_FOUND, also if none lies within the window.
inline int minimum_norm(MinimumNorm<double>& p) {
    const Question asked = question_of(p);
    const int found = find_minimum(p, asked);
    const int status = asked.window && found == INFEASIBLE ? NOT_FOUND : found;
    *p.status = status;
    return status;
}

#ifdef CDPR_LANES
// Return whether lanes require only the least norm within their limits.
CDPR_INLINE Mask plain_lanes(const MinimumNorm<Lanes>& p) {
    if (p.weighted || many_cables(p.n, p.m) || p.about == MIDDLE || p.about == GIVEN) return false;
    return p.about == PREVIOUS || finite(p.change) ? !follows(p) : Mask(true);
}

// Write the tensions of least norm for lanes without active limits, with the bits of each alone; return which these
// are.
CDPR_INLINE Mask unhindered(const MinimumNorm<Lanes>& p) {
    const Mask plain = plain_lanes(p);
    if (!any(plain)) return plain;
    TensionProblem<Lanes> problem = p.problem();
    problem.tension = p.target();
    Factors<Lanes> f = factors_of(problem);
    const int64_t r = reduce_to_point(problem, f);
    const Mask together = plain & common(problem, r);
    if (!any(together)) return together;
    const Excess<Lanes> reach = least(polytope_of(problem, 0, p.x(), p.active()));
    const Difference<Lanes> moved = compared(problem, 0, p.x());
    const Mask within = reach.most <= FEASIBILITY_TOLERANCE * reach.scale;
    const Mask found = together & within & (moved.breach <= BREACH_ROUND_OFF * moved.size);
    for (int64_t i = 0; i < p.m; i++) p.tension[i] = select(found, problem.tension[i], p.tension[i]);
    return found;
}

// Solve the problem of one lane alone, in the lanes' work space.
inline void minimum_norm_alone(MinimumNorm<Lanes>& eight, int lane) {
    const int64_t n = eight.n, m = eight.m;
    Space space = {doubles(eight.factors), lane};
    double status = OK;
    double* factors = space.reserve((n + 5) * (n + m));
    MinimumNorm<double> one = {space.copied(eight.matrix, n * m),
                               space.copied(eight.wrench, n),
                               space.copied(eight.tension_min, m),
                               space.copied(eight.tension_max, m),
                               space.copied(eight.reference, m),
                               space.copied(eight.root, m),
                               space.copied(eight.tension, m),
                               &status,
                               doubles(eight.basis),
                               doubles(eight.box),
                               factors,
                               doubles(eight.search),
                               doubles(eight.vectors),
                               doubles(eight.scaled),
                               eight.change,
                               eight.about,
                               eight.weighted,
                               n,
                               m};
    minimum_norm(one);
    put(one.tension, eight.tension, lane, m);
    eight.status->set(lane, status);
}

// Return the bits of the lanes with a status other than OK.
inline int minimum_norm(MinimumNorm<Lanes>& p) {
    const int found = bits(unhindered(p));
    *p.status = double(OK);
    for (int lane = 0; lane < WIDTH; lane++)
        if ((found >> lane & 1) == 0) minimum_norm_alone(p, lane);
    return bits(*p.status != Lanes(double(OK)));
}
#endif

}  // namespace cdpr::CDPR_TARGET
