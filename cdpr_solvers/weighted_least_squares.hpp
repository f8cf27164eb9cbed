// Least squares with weights over many decades. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/null_space.hpp>

namespace cdpr::CDPR_TARGET {

// A direction in which all weighted rows are below this share of the largest is ignored: its effect is below the
// round-off of the others.
constexpr double UNSEEN = 1e-9;

CDPR_INLINE double power(double base, int64_t exponent) {
    double result = 1.0;
    for (; exponent > 0; exponent /= 2) {
        if (exponent % 2 == 1) result *= base;
        base *= base;
    }
    return result;
}

// min sum u_i^(p-2) (u + G d)_i^2. Modified Gram-Schmidt with column pivoting on the rows and the right-hand side,
// which keeps the small rows accurate beside the large ones (Gulliksson, BIT 35, 1995). With its work space:
struct WeightedLeastSquares {
    Matrix<double> A;  // (r, m), each row a column of the problem
    Matrix<double> R;  // (r, r)
    double* y;         // (r)
    double* column;    // (r), column of each row of A
    double* b;         // (m)
    int64_t m, r;

    // Write the weighted problem, in units of `scale`.
    inline void begin(int64_t p, double scale, Matrix<double> G, const double* u) const {
        for (int64_t i = 0; i < m; i++) {
            const double weight = power(absolute(u[i]) / scale, p / 2 - 1);
            b[i] = -weight * u[i];
            for (int64_t k = 0; k < r; k++) A(k, i) = weight * G(i, k);
        }
        for (int64_t k = 0; k < r; k++) column[k] = double(k);
    }

    // Exchange row k of A for the longest from there on; return its length.
    inline double bring_longest(int64_t k) const {
        int64_t pivot = k;
        double best = -1.0;
        for (int64_t j = k; j < r; j++) {
            const double square = sum(0.0, 0, m, [&](int64_t i) { return A(j, i) * A(j, i); });
            if (square > best) {
                pivot = j;
                best = square;
            }
        }
        R(k, k) = square_root(best);
        if (!(R(k, k) > UNSEEN * R(0, 0))) return 0.0;
        if (pivot != k) {
            swap(column[k], column[pivot]);
            for (int64_t i = 0; i < m; i++) swap(A(k, i), A(pivot, i));
            for (int64_t j = 0; j < k; j++) swap(R(j, k), R(j, pivot));
        }
        return R(k, k);
    }

    // Normalise row k of A, and make the following rows and b orthogonal to it.
    inline void orthogonalise(int64_t k, double length) const {
        y[k] = sum(0.0, 0, m, [&](int64_t i) {
            A(k, i) /= length;
            return A(k, i) * b[i];
        });
        for (int64_t i = 0; i < m; i++) b[i] -= y[k] * A(k, i);
        for (int64_t j = k + 1; j < r; j++) {
            const double s = sum(0.0, 0, m, [&](int64_t i) { return A(k, i) * A(j, i); });
            for (int64_t i = 0; i < m; i++) A(j, i) -= s * A(k, i);
            R(k, j) = s;
        }
    }

    // Write d (r).
    inline void solve(int64_t p, double scale, Matrix<double> G, const double* u, double* d) const {
        begin(p, scale, G, u);
        for (int64_t k = 0; k < r; k++) d[k] = 0.0;
        int64_t rank = 0;
        for (; rank < r; rank++) {
            const double length = bring_longest(rank);
            if (length == 0.0) break;
            orthogonalise(rank, length);
        }
        for (int64_t k = rank - 1; k >= 0; k--) {
            y[k] = difference(y[k], k + 1, rank, [&](int64_t j) { return R(k, j) * y[j]; }) / R(k, k);
            d[whole(column[k])] = y[k];
        }
    }
};

}  // namespace cdpr::CDPR_TARGET
