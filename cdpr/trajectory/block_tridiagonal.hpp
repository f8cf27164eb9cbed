// Symmetric positive definite block-tridiagonal systems with 2 x 2 blocks. SPDX-License-Identifier: Apache-2.0
//
// A block is four numbers, row by row. A positive definite system needs no pivoting.
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

struct BlockTridiagonal {
    const double* diagonal;  // (k + 1, 2, 2)
    const double* upper;     // (k, 2, 2), blocks right of the diagonal
    const double* right;     // (k + 1, 2)
    double* solution;        // (k + 1, 2)
    double* inverse;         // (k + 1, 2, 2), work space: inverses of the blocks of the factorised diagonal
    int64_t k;
    static constexpr char fields[] =
        "diagonal(k + 1, 2, 2), upper(k, 2, 2), right(k + 1, 2), solution(k + 1, 2), work inverse(k + 1, 2, 2), k";
};

// Subtract U^T I U from D, and U^T x from r: the elimination of the previous block, with inverse I and solution x = I
// r.
CDPR_INLINE void eliminate(const double* I, const double* U, const double* x, double* D, double* r) {
    for (int column = 0; column < 2; column++) {
        const double first = I[0] * U[column] + I[1] * U[2 + column];
        const double second = I[2] * U[column] + I[3] * U[2 + column];
        D[column] -= U[0] * first + U[2] * second;
        D[2 + column] -= U[1] * first + U[3] * second;
    }
    r[0] -= U[0] * x[0] + U[2] * x[1];
    r[1] -= U[1] * x[0] + U[3] * x[1];
}

CDPR_INLINE void invert(double* D) {
    const double a = D[0], b = D[1], c = D[2], d = D[3], determinant = a * d - b * c;
    D[0] = d / determinant;
    D[1] = -b / determinant;
    D[2] = -c / determinant;
    D[3] = a / determinant;
}

inline int block_tridiagonal(BlockTridiagonal& system) {
    const int64_t count = system.k + 1;
    const double* U = system.upper;
    double *I = system.inverse, *x = system.solution;
    for (int64_t i = 0; i < 4 * count; i++) I[i] = system.diagonal[i];
    for (int64_t i = 0; i < 2 * count; i++) x[i] = system.right[i];
    for (int64_t k = 0; k < count; k++) {
        double *D = I + 4 * k, *r = x + 2 * k;
        if (k > 0) eliminate(D - 4, U + 4 * (k - 1), r - 2, D, r);
        invert(D);
        const double first = D[0] * r[0] + D[1] * r[1], second = D[2] * r[0] + D[3] * r[1];
        r[0] = first;
        r[1] = second;
    }
    for (int64_t k = count - 2; k >= 0; k--) {
        const double *D = I + 4 * k, *u = U + 4 * k, *next = x + 2 * (k + 1);
        const double first = u[0] * next[0] + u[1] * next[1], second = u[2] * next[0] + u[3] * next[1];
        x[2 * k] -= D[0] * first + D[1] * second;
        x[2 * k + 1] -= D[2] * first + D[3] * second;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
