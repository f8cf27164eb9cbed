// Linear programs with one coordinate more than the null space. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/extreme_point.hpp>

namespace cdpr::CDPR_TARGET {

// min or max s over (x, s), x (r): low <= c + row . x + last s <= high for each row. Its work space:
struct LinearProgram {
    Matrix<double> rows;     // (most, r + 1)
    double *c, *low, *high;  // (most)
    double *point, *active;  // (most)
    double *objective, *y;   // (r + 1); y holds x and s
    double* search;          // (2 r + 10, most + 1)
    int64_t most, r, count;

    CDPR_INLINE void add(Matrix<const double> N, int64_t i, double last, double center, double lower, double upper) {
        for (int64_t j = 0; j < r; j++) rows(count, j) = N(i, j);
        rows(count, r) = last;
        c[count] = center;
        low[count] = lower;
        high[count] = upper;
        count++;
    }

    // Minimise sign * s; return as `extreme`.
    inline int64_t solve(double sign) const {
        for (int64_t j = 0; j < r; j++) objective[j] = 0.0;
        objective[r] = sign;
        const Polytope<double> set = {{rows.data, rows.stride}, c, low, high, y, point, active, r + 1, count};
        ActiveSet active_limits = active_set(search, most + 1, r + 1);
        return extreme(set, active_limits, objective);
    }
};

// Return a program without rows, for at most `most` >= m of them; the work space is (most + 2 m + 17, most + 1), and r
// is at most m.
inline LinearProgram linear_program(double* space, int64_t most, int64_t r) {
    const Matrix<double> table = {space, most + 1}, rest = table.from(most);
    return {table, rest[0], rest[1], rest[2], rest[3], rest[4], rest[5], rest[6], rest[7], most, r, 0};
}

}  // namespace cdpr::CDPR_TARGET
