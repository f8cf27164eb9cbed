// Triangular factors of a growing and shrinking set of vectors. SPDX-License-Identifier: Apache-2.0
//
// The vectors are n_j = J[:, :k] R[:k, j], J (r, r) orthogonal.
#pragma once

#include <cdpr/matrix.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

CDPR_INLINE void set_identity(Matrix<double> J, int64_t r) {
    for (int64_t i = 0; i < r; i++)
        for (int64_t j = 0; j < r; j++) J(i, j) = i == j ? 1.0 : 0.0;
}

// Write y (k): R y = rhs for the leading upper triangle.
CDPR_INLINE void back_substitute(Matrix<double> R, const double* rhs, double* y, int64_t k) {
    for (int64_t i = k - 1; i >= 0; i--)
        y[i] = difference(rhs[i], i + 1, k, [&](int64_t j) { return R(i, j) * y[j]; }) / R(i, i);
}

// Rotation of two numbers. The sine is stored with both signs: the vectoriser of g++ fuses adjacent sums and
// differences of products (vfmaddsub), even with -ffp-contract=off. The bits are those of a difference.
struct Rotation {
    double cosine, sine, minus_sine;

    CDPR_INLINE void turn(double& a, double& b) const {
        const double first = a, second = b;
        a = cosine * first + sine * second;
        b = cosine * second + minus_sine * first;
    }
};

// Rotation that turns (a, b) into (h, 0).
CDPR_INLINE Rotation rotation_of(double a, double b, double h) { return {a / h, b / h, -b / h}; }

// Append vector number k, which is J d: rotate columns k.. of J so that only d[k] remains. d (r) is overwritten.
inline void append(Matrix<double> J, Matrix<double> R, double* d, int64_t r, int64_t k) {
    for (int64_t j = r - 1; j > k; j--) {
        const double a = d[j - 1], b = d[j];
        if (b == 0.0) continue;
        const double h = hypotenuse(a, b);
        const Rotation rotation = rotation_of(a, b, h);
        d[j - 1] = h;
        for (int64_t i = 0; i < r; i++) rotation.turn(J(i, j - 1), J(i, j));
    }
    for (int64_t i = 0; i <= k; i++) R(i, k) = d[i];
}

// Remove vector number `drop` of k, and its entries of u and member (k), and restore the triangular form of R.
inline void remove(Matrix<double> J, Matrix<double> R, double* u, double* member, int64_t r, int64_t k, int64_t drop) {
    for (int64_t j = drop; j < k - 1; j++) {
        u[j] = u[j + 1];
        member[j] = member[j + 1];
        for (int64_t i = 0; i < j + 2; i++) R(i, j) = R(i, j + 1);
    }
    for (int64_t j = drop; j < k - 1; j++) {
        const double a = R(j, j), b = R(j + 1, j);
        if (b == 0.0) continue;
        const double h = hypotenuse(a, b);
        const Rotation rotation = rotation_of(a, b, h);
        R(j, j) = h;
        for (int64_t column = j + 1; column < k - 1; column++) rotation.turn(R(j, column), R(j + 1, column));
        for (int64_t i = 0; i < r; i++) rotation.turn(J(i, j), J(i, j + 1));
    }
}

// Reflect columns k to r of N (m, r), which stay orthonormal, so that row i, of length `size` there, is nonzero only in
// column k. v (r) is work space.
inline void turn(Matrix<double> N, int64_t m, int64_t r, int64_t k, int64_t i, double size, double* v) {
    v[k] = N(i, k) + copy_sign(size, N(i, k));
    for (int64_t j = k + 1; j < r; j++) v[j] = N(i, j);
    const double scale = 1.0 / (size * absolute(v[k]));  // 2 / |v|^2
    for (int64_t row = 0; row < m; row++) {
        const double s = sum(0.0, k, r, [&](int64_t j) { return N(row, j) * v[j]; }) * scale;
        for (int64_t j = k; j < r; j++) N(row, j) -= s * v[j];
    }
    for (int64_t j = k + 1; j < r; j++) N(i, j) = 0.0;  // except for round-off, which would let the row drift
}

}  // namespace cdpr::CDPR_TARGET
