// Small positive definite systems, solved in place (Golub and Van Loan, Matrix Computations, section 4.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/matrix.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

// A direction whose remaining curvature is below this share counts as unobservable: round-off of the factorisation.
constexpr double SINGULAR = 1e-13;

// Replace the lower half of A (n, n) by L, where L L^T = A + damping diag(A); return whether A is not singular. Where
// it is, the rest of its factor has no meaning.
template <class T> CDPR_INLINE Truth<T> factorise(Matrix<T> A, int64_t n, T damping) {
    Truth<T> regular = true;
    for (int64_t k = 0; k < n; k++) {
        for (int64_t j = 0; j < k; j++) {
            T s = A(k, j);
            for (int64_t i = 0; i < j; i++) s -= A(k, i) * A(j, i);
            A(k, j) = s / A(j, j);
        }
        T s = A(k, k) * (1.0 + damping);
        const T least = SINGULAR * s;
        for (int64_t i = 0; i < k; i++) s -= A(k, i) * A(k, i);
        regular = regular & (s > least);
        if (!any(regular)) return regular;
        A(k, k) = square_root(s);
    }
    return regular;
}

// Write x (n,) with L L^T x = b (n,). x may be b.
template <class T> CDPR_INLINE void solve(Matrix<T> L, const T* b, T* x, int64_t n) {
    for (int64_t k = 0; k < n; k++) {
        T s = b[k];
        for (int64_t j = 0; j < k; j++) s -= L(k, j) * x[j];
        x[k] = s / L(k, k);
    }
    for (int64_t k = n - 1; k >= 0; k--) {
        T s = x[k];
        for (int64_t j = k + 1; j < n; j++) s -= L(j, k) * x[j];
        x[k] = s / L(k, k);
    }
}

}  // namespace CDPR_TARGET
}  // namespace cdpr
