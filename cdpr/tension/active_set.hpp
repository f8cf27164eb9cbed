// Nearest point of a polytope { x : low <= c + N x <= high }, by a dual active-set method.
// SPDX-License-Identifier: Apache-2.0
//
// Goldfarb and Idnani, Mathematical Programming 27 (1983), for a Hessian of 1.
#pragma once

#include <cdpr/status.hpp>
#include <cdpr/tension/factors.hpp>
#include <cdpr/tension/polytope.hpp>
#include <cdpr/tension/verdict.hpp>

namespace cdpr::CDPR_TARGET {

// A limit counts as kept within this relative distance, of the largest coordinate: the round-off of the updates.
constexpr double FEASIBILITY_TOLERANCE = 1e-13;

// A constraint normal depends on the active ones if its part orthogonal to them is below this share of its length.
constexpr double DEPENDENCE_TOLERANCE = 1e-11;

// Active limits of x, k of them, and factors of their normals: N^T of them is J[:, :k] R.
struct ActiveSet {
    Matrix<double> J, R;  // (r, r)
    double* d;            // (r), a normal in the columns of J
    double* z;            // (r), direction in which x moves
    double* dual;         // (r), rates of the multipliers
    double* u;            // (r), multipliers
    double* member;       // (r), the cable of each
    double* size;         // (m), lengths of the rows of N
    double* rotated;      // (r), the objective in the columns of J
    int64_t k;
};

// Views of its work space: (2 r + 8, max(m, r)).
CDPR_INLINE ActiveSet active_set(double* work, int64_t stride, int64_t r) {
    const Matrix<double> rows = {work, stride};
    const Matrix<double> rest = rows.from(2 * r);
    return {rows, rows.from(r), rest[0], rest[1], rest[2], rest[3], rest[4], rest[5], rest[6], 0};
}

CDPR_INLINE void write_lengths(const Polytope<double>& p, const ActiveSet& s) {
    for (int64_t i = 0; i < p.m; i++)
        s.size[i] = square_root(sum(0.0, 0, p.r, [&](int64_t j) { return p.N(i, j) * p.N(i, j); }));
}

// A limit of a cable.
struct Limit {
    int64_t cable;  // -1: none
    double side;    // 1 for the lower one, -1 for the upper one
};

// Write the normal of a limit in the columns of J.
CDPR_INLINE void write_normal(const Polytope<double>& p, const ActiveSet& s, Limit limit) {
    for (int64_t j = 0; j < p.r; j++)
        s.d[j] = limit.side * sum(0.0, 0, p.r, [&](int64_t i) { return s.J(i, j) * p.N(limit.cable, i); });
}

// Activate a limit, whose normal is d, with a multiplier.
CDPR_INLINE void activate(const Polytope<double>& p, ActiveSet& s, Limit limit, double multiplier) {
    append(s.J, s.R, s.d, p.r, s.k);
    s.u[s.k] = multiplier;
    s.member[s.k] = double(limit.cable);
    p.active[limit.cable] = -limit.side;
    s.k++;
}

// Release active limit number `drop`.
CDPR_INLINE void release(const Polytope<double>& p, ActiveSet& s, int64_t drop) {
    p.active[whole(s.member[drop])] = 0.0;
    remove(s.J, s.R, s.u, s.member, p.r, s.k, drop);
    s.k--;
}

// Find the limit that is violated most, in lengths of x. Return -INFEASIBLE if x has no influence on a violated one.
CDPR_INLINE int most_broken(const Polytope<double>& p, const ActiveSet& s, Excess<double> reach, Limit& found) {
    double worst = 0.0;
    found = {-1, 0.0};
    for (int64_t i = 0; i < p.m; i++) {
        if (p.active[i] != 0.0) continue;
        const double below = p.low[i] - p.point[i], above = p.point[i] - p.high[i];
        const double excess = larger(below, above);
        if (!(excess > FEASIBILITY_TOLERANCE * reach.scale)) continue;
        if (s.size[i] == 0.0) {
            if (excess > VERTEX_TOLERANCE * reach.scale) return -INFEASIBLE;
        } else if (excess > worst * s.size[i]) {
            worst = excess / s.size[i];
            found = {i, below > above ? 1.0 : -1.0};
        }
    }
    return OK;
}

// Move x along J[:, k:] d[k:], the part of the normal that is orthogonal to the active ones, and the point with it.
CDPR_INLINE void move(const Polytope<double>& p, const ActiveSet& s, double step) {
    for (int64_t i = 0; i < p.r; i++) {
        s.z[i] = sum(0.0, s.k, p.r, [&](int64_t j) { return s.J(i, j) * s.d[j]; });
        p.x[i] += step * s.z[i];
    }
    for (int64_t i = 0; i < p.m; i++)
        p.point[i] += step * sum(0.0, 0, p.r, [&](int64_t j) { return p.N(i, j) * s.z[j]; });
}

// Move x onto a violated limit, and release others on the way. Return OK or minus a status.
CDPR_INLINE int enforce(const Polytope<double>& p, ActiveSet& s, Limit limit, double scale, int64_t& left) {
    const int64_t i = limit.cable;
    double multiplier = 0.0;
    while (true) {
        if (--left < 0) return -NOT_FOUND;
        const double slack = limit.side > 0.0 ? p.point[i] - p.low[i] : p.high[i] - p.point[i];
        write_normal(p, s, limit);
        const double square = sum(0.0, s.k, p.r, [&](int64_t j) { return s.d[j] * s.d[j]; });
        back_substitute(s.R, s.d, s.dual, s.k);
        // Largest step that the active multipliers allow, and full step that the constraint itself requires.
        double partial = INFINITE;
        int64_t drop = -1;
        for (int64_t j = 0; j < s.k; j++)
            if (s.dual[j] > DEPENDENCE_TOLERANCE && s.u[j] < partial * s.dual[j]) {
                partial = s.u[j] / s.dual[j];
                drop = j;
            }
        const double shortest = DEPENDENCE_TOLERANCE * s.size[i];
        const bool independent = square > shortest * shortest;
        const double full = independent ? -slack / square : INFINITE;
        const double step = smaller(partial, full);
        if (step == INFINITE) {
            if (-slack > VERTEX_TOLERANCE * scale) return -INFEASIBLE;
            p.active[i] = -limit.side;
            return OK;
        }
        for (int64_t j = 0; j < s.k; j++) s.u[j] -= step * s.dual[j];
        multiplier += step;
        if (independent) move(p, s, step);
        if (full <= partial) {
            activate(p, s, limit, multiplier);
            return OK;
        }
        release(p, s, drop);
    }
}

// Write the x of least norm; return the number of steps, -INFEASIBLE if the polytope is empty, or -NOT_FOUND after a
// number of steps that no regular problem needs.
inline int64_t nearest(const Polytope<double>& p, ActiveSet& s) {
    for (int64_t j = 0; j < p.r; j++) p.x[j] = 0.0;
    s.k = 0;
    const Excess<double> reach = least(p);
    if (reach.most <= FEASIBILITY_TOLERANCE * reach.scale) return 0;  // no limit is active
    for (int64_t i = 0; i < p.m; i++) p.point[i] = p.center[i];
    write_lengths(p, s);
    const int64_t most = 10 * (p.r + 1) + 4 * p.m;
    int64_t left = most;
    while (true) {
        Limit limit;
        const int status = most_broken(p, s, reach, limit);
        if (status != OK) return status;
        if (limit.cable < 0) break;
        if (s.k == 0) set_identity(s.J, p.r);
        const int enforced = enforce(p, s, limit, reach.scale, left);
        if (enforced != OK) return enforced;
    }
    settle(p);
    return most - left;
}

}  // namespace cdpr::CDPR_TARGET
