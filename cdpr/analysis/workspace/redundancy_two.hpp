// Facets of robots with two redundant cables, the most common number. SPDX-License-Identifier: Apache-2.0
//
// An elementary vector p of W's row space (facets.hpp) is then a cross product of three rows of N (m, 2).
#pragma once

#include <cdpr/analysis/workspace/facets.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int64_t TWO = 2;  // redundant cables

// Numbers of a pose, and work space.
template <class T> struct TwoMore {
    int64_t form, n, m, k;
    Matrix<const T> W;         // (n, m)
    Matrix<const T> N;         // (m, 2)
    Matrix<const T> required;  // (k, n)
    const T* center;           // (m), c, a solution for the wrench of the weight
    const T* low;              // (m)
    const T* high;             // (m)
    Matrix<T> gram;            // (n, n)
    Matrix<T> Y;               // (n, m), transpose of the pseudo-inverse of W: c = Y p
    Matrix<T> G;               // (m, m), Y^T Y, its upper half
    Matrix<T> Z;               // (k, m), of the required set
    T* off;                    // (m), of c relative to the middle of the limits
    T* half;                   // (m), half ranges of the limits
    T* best;                   // (n), unit normal of the nearest facet
};

template <class T> CDPR_INLINE T minor(Matrix<const T> N, int64_t i, int64_t j) {
    return N(i, 0) * N(j, 1) - N(i, 1) * N(j, 0);
}

// Write Y = (W W^T)^-1 W, Y^T Y, and Y^T times the vectors of the required set; return whether that is possible.
template <class T> inline Truth<T> project(const TwoMore<T>& two) {
    const int64_t n = two.n, m = two.m;
    const Matrix<const T> W = two.W;
    const Matrix<T> L = two.gram, Y = two.Y;
    for (int64_t j = 0; j < n; j++)
        for (int64_t k = 0; k <= j; k++)
            L(j, k) = sum(W(j, 0) * W(k, 0), 1, m, [&](int64_t i) { return W(j, i) * W(k, i); });
    const Truth<T> regular = factorise(L, n, T(0.0));
    if (!any(regular)) return regular;
    T* inverse = two.best;  // of the diagonal
    for (int64_t j = 0; j < n; j++) inverse[j] = 1.0 / L(j, j);
    for (int64_t i = 0; i < m; i++) {
        for (int64_t j = 0; j < n; j++)
            Y(j, i) = difference(W(j, i), 0, j, [&](int64_t k) { return L(j, k) * Y(k, i); }) * inverse[j];
        for (int64_t j = n - 1; j >= 0; j--)
            Y(j, i) = difference(Y(j, i), j + 1, n, [&](int64_t k) { return L(k, j) * Y(k, i); }) * inverse[j];
    }
    for (int64_t i = 0; i < m; i++) {
        for (int64_t k = i; k < m; k++)
            two.G(i, k) = sum(Y(0, i) * Y(0, k), 1, n, [&](int64_t j) { return Y(j, i) * Y(j, k); });
        for (int64_t v = 0; v < two.k; v++)
            two.Z(v, i) =
                sum(two.required(v, 0) * Y(0, i), 1, n, [&](int64_t j) { return two.required(v, j) * Y(j, i); });
    }
    return regular;
}

// Nearest facet so far: its margin times the length of its normal, the square of that length, the largest term of that
// difference, 1 or -1 if the normal points to the facet or away, and the three entries of p.
template <class T> struct NearestFacet {
    T margin = INFINITE, square = 1.0, scale = 0.0, sign = 1.0;
    T cable[3] = {0.0, 0.0, 0.0}, entry[3] = {0.0, 0.0, 0.0};
};

// Write margin, N, and scale into `value` (2), and the normal; return whether these exist. Only the square of the
// length of c = Y p is computed, from Y^T Y, and its products with the required set, from Z; c itself only for the
// nearest facet. Relative to the middle of the limits the cables reach equally far along c and against it.
template <int form, class T> inline Truth<T> margin_of_two(const TwoMore<T>& two, T* value) {
    const Truth<T> regular = project(two);
    if (!any(regular)) return regular;
    const int64_t n = two.n, m = two.m;
    const Matrix<const T> N = two.N;
    const Matrix<T> G = two.G, Z = two.Z;
    for (int64_t i = 0; i < m; i++) {
        two.off[i] = two.center[i] - 0.5 * (two.low[i] + two.high[i]);
        two.half[i] = 0.5 * (two.high[i] - two.low[i]);
    }
    NearestFacet<T> nearest;
    for (int64_t i = 0; i < m - 2; i++) {
        for (int64_t j = i + 1; j < m - 1; j++) {
            const T twice = 2.0 * G(i, j), p2 = minor(N, i, j), size2 = absolute(p2), part2 = p2 * p2;
            for (int64_t k = j + 1; k < m; k++) {
                const T p0 = minor(N, j, k), p1 = minor(N, k, i);
                const T base = p0 * two.off[i] + p1 * two.off[j] + p2 * two.off[k];
                const T reached = absolute(p0) * two.half[i] + absolute(p1) * two.half[j] + size2 * two.half[k];
                T square = p0 * (p0 * G(i, i) + p1 * twice) + p1 * p1 * G(j, j);
                square += p2 * (p2 * G(k, k) + 2.0 * (p0 * G(i, k) + p1 * G(j, k)));
                Reach<T> reach;
                for (int64_t v = 0; v < two.k; v++) reach.add(form, v, p0 * Z(v, i) + p1 * Z(v, j) + p2 * Z(v, k));
                reach.end(form);
                const T over = -base - reach.ahead, under = base - reach.behind;
                const T margin = reached + smaller(over, under);
                // The smaller margin / sqrt(square) is found without roots and quotients.
                const T before = nearest.margin * absolute(nearest.margin) * square;
                const Truth<T> nearer = (margin * absolute(margin) * nearest.square < before) &
                                        (p0 * p0 + p1 * p1 + part2 > T(DEPENDENT * DEPENDENT));
                if (!any(nearer)) continue;
                nearest.margin = select(nearer, margin, nearest.margin);
                nearest.square = select(nearer, square, nearest.square);
                nearest.scale = select(nearer, reached + absolute(base) + reach.ahead, nearest.scale);
                nearest.sign = select(nearer, select(over < under, T(1.0), T(-1.0)), nearest.sign);
                const T cable[3] = {double(i), double(j), double(k)}, entry[3] = {p0, p1, p2};
                for (int e = 0; e < 3; e++) {
                    nearest.cable[e] = select(nearer, cable[e], nearest.cable[e]);
                    nearest.entry[e] = select(nearer, entry[e], nearest.entry[e]);
                }
            }
        }
    }
    const T length = square_root(nearest.square);
    for (int64_t q = 0; q < n; q++) {
        const T c = sum(T(0.0), 0, m, [&](int64_t i) {
            T entry = 0.0;
            for (int e = 2; e >= 0; e--) entry = select(nearest.cable[e] == T(double(i)), nearest.entry[e], entry);
            return two.Y(q, i) * entry;
        });
        two.best[q] = nearest.sign * c / length;
    }
    value[0] = nearest.margin / length;
    value[1] = nearest.scale / length;
    return regular & (nearest.square > T(0.0));
}

template <class T> inline Truth<T> margin_of_two(const TwoMore<T>& two, T* value) {
    if (two.form == ZONOTOPE) return margin_of_two<ZONOTOPE>(two, value);
    if (two.form == ELLIPSOID) return margin_of_two<ELLIPSOID>(two, value);
    return margin_of_two<VERTICES>(two, value);
}

// Return the smallest absolute value of the sign that is rarer in a unit elementary vector; negative if it has one
// sign.
template <class T> inline T closure_of_two(Matrix<const T> N, int64_t m) {
    T least = INFINITE, square = 1.0;
    for (int64_t i = 0; i < m - 2; i++) {
        for (int64_t j = i + 1; j < m - 1; j++) {
            const T p2 = minor(N, i, j);
            for (int64_t k = j + 1; k < m; k++) {
                const T p0 = minor(N, j, k), p1 = minor(N, k, i);
                const T size = p0 * p0 + p1 * p1 + p2 * p2;
                const T value = smaller(larger(p0, larger(p1, p2)), -smaller(p0, smaller(p1, p2)));
                // The smaller value / sqrt(size) is found without roots and quotients.
                const Truth<T> less = (value * absolute(value) * square < least * absolute(least) * size) &
                                      (size > T(DEPENDENT * DEPENDENT));
                least = select(less, value, least);
                square = select(less, size, square);
            }
        }
    }
    return least / square_root(square);
}

}  // namespace cdpr::CDPR_TARGET
