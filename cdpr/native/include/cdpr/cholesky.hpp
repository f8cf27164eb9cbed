// Small positive definite systems, solved in place (Golub and Van Loan, Matrix Computations, section 4.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/matrix.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

// A direction with remaining curvature below this share counts as unobservable: round-off of the factorisation.
constexpr double SINGULAR = 1e-13;

// Replace the lower half of A (n, n) by L, where L L^T = A + damping diag(A); return whether A is regular. The rest of
// the factor of a singular matrix has no meaning.
template <class T> CDPR_INLINE Truth<T> factorise(Matrix<T> A, int64_t n, T damping) {
    Truth<T> regular = true;
    for (int64_t k = 0; k < n; k++) {
        for (int64_t j = 0; j < k; j++)
            A(k, j) = difference(A(k, j), 0, j, [&](int64_t i) { return A(k, i) * A(j, i); }) / A(j, j);
        const T whole = A(k, k) * (1.0 + damping);
        const T left = difference(whole, 0, k, [&](int64_t i) { return A(k, i) * A(k, i); });
        regular = regular & (left > SINGULAR * whole);
        if (!any(regular)) return regular;
        A(k, k) = square_root(left);
    }
    return regular;
}

// Write x (n,) with L L^T x = b (n,). x may be b.
template <class T> CDPR_INLINE void solve(Matrix<T> L, const T* b, T* x, int64_t n) {
    for (int64_t k = 0; k < n; k++) x[k] = difference(b[k], 0, k, [&](int64_t j) { return L(k, j) * x[j]; }) / L(k, k);
    for (int64_t k = n - 1; k >= 0; k--)
        x[k] = difference(x[k], k + 1, n, [&](int64_t j) { return L(j, k) * x[j]; }) / L(k, k);
}

}  // namespace cdpr::CDPR_TARGET
