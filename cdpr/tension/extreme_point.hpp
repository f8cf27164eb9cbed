// Extreme point of a polytope, the optimum of a linear program. SPDX-License-Identifier: Apache-2.0
//
// x(s) = argmin |x|^2 / 2 + s g . x is followed from s = 0, the nearest point, along its straight pieces until it is
// constant, which for a linear program happens at a finite s (Mangasarian and Meyer, SIAM J. Control Optim. 17, 1979).
// So the answer is unique, whatever the order of the cables.
#pragma once

#include <cdpr/tension/active_set.hpp>

namespace cdpr::CDPR_TARGET {

// Move x back onto the active limits after the round-off of many steps.
inline void correct(const Polytope<double>& p, const ActiveSet& s) {
    double* y = s.d;
    for (int64_t j = 0; j < s.k; j++) {  // R^T y = violation of each active limit
        const int64_t i = whole(s.member[j]);
        const double left = difference(-p.center[i], 0, p.r, [&](int64_t q) { return p.N(i, q) * p.x[q]; });
        const double lack = p.active[i] < 0.0 ? left + p.low[i] : -(left + p.high[i]);
        y[j] = difference(lack, 0, j, [&](int64_t q) { return s.R(q, j) * y[q]; }) / s.R(j, j);
    }
    for (int64_t i = 0; i < p.r; i++) p.x[i] = sum(p.x[i], 0, s.k, [&](int64_t j) { return s.J(i, j) * y[j]; });
}

// End of a straight piece of x(s), at `step`: an active limit is released, or another one is reached.
struct Piece {
    double step;
    int64_t drop;
    Limit limit;
};

// Find the active limit whose multiplier becomes zero first.
CDPR_INLINE Piece first_released(const ActiveSet& s, double length) {
    Piece piece = {INFINITE, -1, {-1, 0.0}};
    for (int64_t j = 0; j < s.k; j++)
        if (s.dual[j] < -DEPENDENCE_TOLERANCE * length && s.u[j] < -piece.step * s.dual[j]) {
            piece.step = larger(s.u[j], 0.0) / -s.dual[j];
            piece.drop = j;
        }
    return piece;
}

// Find the limit that the point reaches before that, as x moves along z at a rate `moving`.
CDPR_INLINE void find_reached(const Polytope<double>& p, const ActiveSet& s, double moving, Piece& piece) {
    for (int64_t i = 0; i < p.m; i++) {
        if (p.active[i] != 0.0) continue;
        const double rate = sum(0.0, 0, p.r, [&](int64_t j) { return p.N(i, j) * s.z[j]; }), speed = absolute(rate);
        if (!(speed > DEPENDENCE_TOLERANCE * s.size[i] * moving)) continue;
        const double room = rate > 0.0 ? p.high[i] - p.point[i] : p.point[i] - p.low[i];
        if (room < piece.step * speed) {
            piece.step = larger(room, 0.0) / speed;
            piece.limit = {i, rate < 0.0 ? 1.0 : -1.0};
        }
    }
}

// Write dx/ds into z, minus the part of g orthogonal to the active normals, and du/ds into `dual`, the multipliers of
// the other part. Return the speed of x in its fastest direction.
CDPR_INLINE double write_rates(const Polytope<double>& p, const ActiveSet& s, const double* g, double length) {
    double moving = 0.0;
    for (int64_t j = 0; j < p.r; j++) {
        s.rotated[j] = sum(0.0, 0, p.r, [&](int64_t i) { return s.J(i, j) * g[i]; });
        if (j >= s.k) moving = larger(moving, absolute(s.rotated[j]));
    }
    back_substitute(s.R, s.rotated, s.dual, s.k);
    const bool moves = moving > DEPENDENCE_TOLERANCE * length;
    for (int64_t i = 0; i < p.r; i++)
        s.z[i] = moves ? difference(0.0, s.k, p.r, [&](int64_t j) { return s.J(i, j) * s.rotated[j]; }) : 0.0;
    return moving;
}

// Advance x, the multipliers, and the point except its active limits.
CDPR_INLINE void advance(const Polytope<double>& p, const ActiveSet& s, double step) {
    for (int64_t j = 0; j < s.k; j++) s.u[j] += step * s.dual[j];
    for (int64_t i = 0; i < p.r; i++) p.x[i] += step * s.z[i];
    for (int64_t i = 0; i < p.m; i++)
        if (p.active[i] == 0.0) p.point[i] = coordinate(p, i);
}

// Follow x(s) from the nearest point, which took `steps`.
CDPR_INLINE int64_t follow(const Polytope<double>& p, ActiveSet& s, const double* g, double length, int64_t steps) {
    const int64_t most = 50 * (p.r + 1) + 10 * p.m;
    for (int64_t trial = 0; trial < most; trial++) {
        steps++;
        const double moving = write_rates(p, s, g, length);
        const bool moves = moving > DEPENDENCE_TOLERANCE * length;
        Piece piece = first_released(s, length);
        if (moves) find_reached(p, s, moving, piece);
        if (piece.step == INFINITE) {
            correct(p, s);
            settle(p);
            return moves ? -int64_t(UNSUPPORTED) : steps;
        }
        advance(p, s, piece.step);
        const int64_t i = piece.limit.cable;
        if (i >= 0) {
            write_normal(p, s, piece.limit);
            activate(p, s, piece.limit, 0.0);
            p.point[i] = piece.limit.side > 0.0 ? p.low[i] : p.high[i];
        } else {
            release(p, s, piece.drop);
        }
    }
    return -NOT_FOUND;
}

// Write the x that minimises g . x, with the least norm if there are several. Return the number of steps; minus a
// status as `nearest`; or -UNSUPPORTED if g . x has no minimum: x is then the start of the last piece, a ray.
inline int64_t extreme(const Polytope<double>& p, ActiveSet& s, const double* g) {
    const int64_t steps = nearest(p, s);
    if (steps < 0) return steps;
    int64_t held = 0;
    for (int64_t i = 0; i < p.m; i++) held += p.active[i] != 0.0;
    if (held > s.k) return steps;  // by more limits than there are dimensions: a single vertex
    if (steps == 0) write_lengths(p, s);
    double length = 0.0;
    for (int64_t i = 0; i < p.r; i++) length = larger(length, absolute(g[i]));
    if (s.k == 0) set_identity(s.J, p.r);
    return follow(p, s, g, length, steps);
}

}  // namespace cdpr::CDPR_TARGET
