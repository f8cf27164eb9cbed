// Solution of a small positive definite system. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/field.hpp>
#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

// Return whether each lane, or the one problem, has no solution: bits, 1 for the first.
CDPR_INLINE int missing(bool answered) { return answered ? 0 : 1; }
#ifdef CDPR_LANES
CDPR_INLINE int missing(Mask answered) { return bits(!answered); }
#endif

// Solve (A + damping diag(A)) x = b. Return 0, or the bits of lanes with a singular matrix.
template <class T> struct PositiveDefinite {
    const T* matrix;  // (n, n), A; only its lower half is read
    const T* right;   // (n), b
    T* solution;      // (n), x; NaN for a singular matrix
    T* factor;        // (n, n), work space: L
    double damping;   // 1, not negative; as in the method of Levenberg and Marquardt
    int64_t n;
    static constexpr char fields[] = "matrix(n, n), right(n), solution(n), work factor(n, n), damping, n";
};

template <class T> inline int positive_definite(PositiveDefinite<T>& system) {
    const int64_t n = system.n;
    const Matrix<T> L = {system.factor, n};
    for (int64_t k = 0; k < n; k++)
        for (int64_t j = 0; j <= k; j++) L(k, j) = system.matrix[k * n + j];
    const Truth<T> regular = factorise(L, n, T(system.damping));
    if (any(regular)) solve(L, system.right, system.solution, n);
    for (int64_t k = 0; k < n; k++)
        system.solution[k] = any(regular) ? select(regular, system.solution[k], T(NOT_A_NUMBER)) : T(NOT_A_NUMBER);
    return missing(regular);
}

}  // namespace cdpr::CDPR_TARGET
