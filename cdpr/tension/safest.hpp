// Point of { x : low <= c + N x <= high } farthest from all limits. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/tension/linear_program.hpp>

namespace cdpr::CDPR_TARGET {

// Write x and return the largest s with low + s d <= c + N x <= high - s d; the x of least norm if there are several.
// d_i is 1, so that s is the smallest distance of a tension from its limits; with `ball` it is the length of row i of
// N, so that s is the radius of the largest ball within the limits, and x its centre (Chebyshev). Locked cables do not
// count. s is negative if no x lies within the limits; infinite if x changes no cable or infinite limits do not bound
// s; NaN if the linear program was not solved. `space` is (4 m + 17, 2 m + 1).
inline double safest_point(bool ball, const Polytope<double>& set, double* space) {
    LinearProgram program = linear_program(space, 2 * set.m, set.r);
    for (int64_t j = 0; j < set.r; j++) set.x[j] = 0.0;
    double stuck = 0.0, scale = 0.0;
    for (int64_t i = 0; i < set.m; i++) {
        const double c = set.center[i], low = set.low[i], high = set.high[i];
        scale = larger(scale, absolute(c));
        const double size = square_root(sum(0.0, 0, set.r, [&](int64_t j) { return set.N(i, j) * set.N(i, j); }));
        if (ball && size == 0.0) {  // independent of x: it only has to be valid
            stuck = larger(larger(stuck, low - c), c - high);
            continue;
        }
        if (low == high) continue;
        const double d = ball ? size : 1.0;
        program.add(set.N, i, -d, c, low, INFINITE);
        program.add(set.N, i, d, c, -INFINITE, high);
    }
    if (stuck > VERTEX_TOLERANCE * scale) return -stuck;
    if (program.count == 0) return INFINITE;
    const int64_t steps = program.solve(-1.0);
    for (int64_t j = 0; j < set.r; j++) set.x[j] = program.y[j];
    if (steps < 0) return steps == -UNSUPPORTED ? INFINITE : NOT_A_NUMBER;
    return program.y[set.r];
}

struct SafestPoint {
    const double* basis;  // (m, r), N, rows that are round-off made zero
    const double* box;    // (3, m), N: c and the limits, which may be infinite
    double* x;            // (r)
    double* distance;     // (1), s
    double* space;        // (4 m + 17, 2 m + 1), work space
    int64_t ball;         // 1: distances in x; 0: of tensions, N
    int64_t m;
    int64_t r;
    static constexpr char fields[] =
        "basis(m, r), box(3, m), x(r), distance(1), work space(4*m + 17, 2*m + 1), ball, m, r";
};

// Return OK, or NOT_FOUND if the distance is NaN.
inline int safest_points(SafestPoint& p) {
    const Polytope<double> set = {{p.basis, p.r}, p.box, p.box + p.m, p.box + 2 * p.m, p.x, nullptr, nullptr, p.r, p.m};
    *p.distance = safest_point(p.ball != 0, set, p.space);
    return *p.distance != *p.distance ? NOT_FOUND : OK;
}

}  // namespace cdpr::CDPR_TARGET
