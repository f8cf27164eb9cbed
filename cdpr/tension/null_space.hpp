// Null-space form of a tension distribution, t = c + N x. SPDX-License-Identifier: Apache-2.0
//
// It contains all solutions of W t = wrench. c is that of least norm, except for locked cables: their tension is given
// and the others balance the rest. The columns of N are orthonormal and orthogonal to c. A row of N is exactly zero if
// and only if x does not change that cable: it is locked, or the wrench alone determines its tension.
#pragma once

#include <cdpr/sum.hpp>
#include <cdpr/tension/tension_problem.hpp>

namespace cdpr::CDPR_TARGET {

constexpr double RANK_TOLERANCE = 1e-9;  // as in cdpr.model.rank

// A dependent row is consistent if the wrench agrees with the other rows to this share of the largest load.
constexpr double CONSISTENCY_TOLERANCE = 1e-9;

// Round-off: a row of N, with columns of unit length, shorter than this.
constexpr double ROUNDING = 1e-11;

// Sums of coordinates beyond this may be infinite: no such tensions exist.
constexpr double TOO_LARGE = 1e300;

// Work space, one row per name; `rows` are the rows of W, and then their Householder vectors.
template <class T> struct Factors {
    Matrix<T> rows;  // (n, free)
    T* rhs;          // (n), remaining wrench, then R^-T rhs
    T* cable;        // (free), number of each unlocked cable
    T* scale;        // (n), of the Householder vectors
    T* diagonal;     // (n), of R
    T* y;            // (max(n, free)), squares of the rows' lengths, then a vector that is reflected
    int64_t n, free, rank;
};

template <class T> CDPR_INLINE Factors<T> factors_of(const TensionProblem<T>& problem) {
    const Matrix<T> rows = problem.work_rows();
    const int64_t n = problem.n;
    return {rows, rows[n], rows[n + 1], rows[n + 2], rows[n + 3], rows[n + 4], n, 0, 0};
}

// Exchange row k and its data for the longest row from there on; return the square of its length.
CDPR_INLINE double bring_longest(const Factors<double>& f, int64_t k) {
    int64_t pivot = k;
    for (int64_t j = k + 1; j < f.n; j++)
        if (f.y[j] > f.y[pivot]) pivot = j;
    if (pivot != k) {
        swap(f.rhs[k], f.rhs[pivot]);
        for (int64_t i = 0; i < f.free; i++) swap(f.rows(k, i), f.rows(pivot, i));
    }
    return f.y[pivot];
}

// The same for lanes, each with its own row.
template <class T> CDPR_INLINE T bring_longest(const Factors<T>& f, int64_t k) {
    T longest = f.y[k], pivot = 0.0 * longest + double(k);
    for (int64_t j = k + 1; j < f.n; j++) {
        const Truth<T> longer = f.y[j] > longest;
        longest = select(longer, f.y[j], longest);
        pivot = select(longer, T(double(j)), pivot);
    }
    for (int64_t j = k + 1; j < f.n; j++) {
        const Truth<T> here = pivot == T(double(j));
        if (!any(here)) continue;
        const T kept = f.rhs[k];
        f.rhs[k] = select(here, f.rhs[j], kept);
        f.rhs[j] = select(here, kept, f.rhs[j]);
        for (int64_t i = 0; i < f.free; i++) {
            const T a = f.rows(k, i), b = f.rows(j, i);
            f.rows(k, i) = select(here, b, a);
            f.rows(j, i) = select(here, a, b);
        }
    }
    return longest;
}

// Reflect row j by the Householder vector v of row k; return the square of the remaining length.
template <class T> CDPR_INLINE T reflect_row(const Factors<T>& f, int64_t k, int64_t j) {
    const T* v = f.rows[k];
    T* row = f.rows[j];
    const T s = sum(T(0.0), k, f.free, [&](int64_t i) { return v[i] * row[i]; }) * f.scale[k];
    row[k] -= s * v[k];
    return sum(T(0.0), k + 1, f.free, [&](int64_t i) {
        const T value = row[i] - s * v[i];
        row[i] = value;
        return value * value;
    });
}

// Householder factorisation with pivoting (Golub and Van Loan, algorithm 5.4.1) of the transpose of `rows`. Write the
// rank and R^-T rhs; return the rank or minus a status.
template <class T> CDPR_INLINE int64_t triangulate(Factors<T>& f, T allowed) {
    for (int64_t j = 0; j < f.n; j++)
        f.y[j] = sum(T(0.0), 0, f.free, [&](int64_t i) { return f.rows(j, i) * f.rows(j, i); });
    T largest = 0.0;
    f.rank = 0;
    for (int64_t k = 0; k < (f.n < f.free ? f.n : f.free); k++) {
        const T norm = square_root(bring_longest(f, k));
        if (k == 0) largest = norm;
        if (!any(norm > RANK_TOLERANCE * largest)) break;
        const T alpha = f.rows(k, k), beta = select(alpha >= T(0.0), -norm, norm);
        // H = 1 - scale v v^T with v = column - beta e_k turns the column into beta e_k.
        f.rows(k, k) = alpha - beta;
        f.scale[k] = 1.0 / (norm * (norm + absolute(alpha)));
        f.diagonal[k] = beta;
        for (int64_t j = k + 1; j < f.n; j++) f.y[j] = reflect_row(f, k, j);
        f.rank++;
    }
    // R^T y = rhs, row by row; dependent rows must agree.
    for (int64_t j = 0; j < f.n; j++) {
        const int64_t before = j < f.rank ? j : f.rank;
        const T s = difference(f.rhs[j], 0, before, [&](int64_t k) { return f.rows(j, k) * f.rhs[k]; });
        if (j < f.rank) {
            f.rhs[j] = s / f.diagonal[j];
            if (!any(absolute(f.rhs[j]) < T(TOO_LARGE))) return -NOT_FOUND;
        } else if (!any(absolute(s) <= allowed)) {
            return -INFEASIBLE;
        }
    }
    return f.rank;
}

// Write limits and locked tensions into the box; return the number of free cables, or minus a status.
template <class T> CDPR_INLINE int64_t lock_cables(const TensionProblem<T>& problem, const Factors<T>& f) {
    int64_t free = 0;
    for (int64_t i = 0; i < problem.m; i++) {
        const T low = problem.tension_min[i], high = problem.tension_max[i];
        if (!any(low <= high)) return -BAD_INPUT;  // NaN, too
        problem.center()[i] = low;                 // tension of a locked cable
        problem.low()[i] = low;
        problem.high()[i] = high;
        if (any(low < high)) f.cable[free++] = double(i);
    }
    return free;
}

// Write factors of W; return its rank or minus a status.
template <class T> inline int64_t factorise(const TensionProblem<T>& problem, Factors<T>& f) {
    const int64_t m = problem.m, free = lock_cables(problem, f);
    if (free < 0) return free;
    f.free = free;
    T sound = 0.0, load = 0.0;  // `sound` is NaN if an entry is not finite
    for (int64_t j = 0; j < f.n; j++) {
        const T* row = problem.matrix + j * m;
        T s = problem.wrench[j];
        load = larger(load, absolute(s));
        for (int64_t i = 0; i < m; i++) {
            sound += 0.0 * row[i];
            if (free < m && !any(problem.tension_min[i] < problem.tension_max[i])) {
                s -= row[i] * problem.tension_min[i];
                load = larger(load, absolute(row[i] * problem.tension_min[i]));
            }
        }
        f.rhs[j] = s;
        sound += 0.0 * s;
        for (int64_t k = 0; k < free; k++) f.rows(j, k) = row[whole(f.cable[k])];
    }
    if (!any(sound == T(0.0))) return -BAD_INPUT;
    return triangulate(f, CONSISTENCY_TOLERANCE * load);
}

// Multiply y by the orthogonal factor.
template <class T> CDPR_INLINE void turn_back(const Factors<T>& f) {
    for (int64_t k = f.rank - 1; k >= 0; k--) {
        const T* v = f.rows[k];
        const T s = sum(T(0.0), k, f.free, [&](int64_t i) { return v[i] * f.y[i]; }) * f.scale[k];
        for (int64_t i = k; i < f.free; i++) f.y[i] -= s * v[i];
    }
}

// Write c into the box.
template <class T> CDPR_INLINE void write_center(const TensionProblem<T>& problem, const Factors<T>& f) {
    for (int64_t i = 0; i < f.free; i++) f.y[i] = i < f.rank ? f.rhs[i] : T(0.0);
    turn_back(f);
    for (int64_t i = 0; i < f.free; i++) problem.center()[whole(f.cable[i])] = f.y[i];
}

// Write columns `begin` to `end` - 1 of the orthogonal factor as the first ones of the basis.
template <class T>
CDPR_INLINE void write_columns(const TensionProblem<T>& problem, const Factors<T>& f, int64_t begin, int64_t end) {
    const Matrix<T> basis = problem.N();
    if (f.free < problem.m)
        for (int64_t i = 0; i < problem.m; i++)
            for (int64_t k = 0; k < end - begin; k++) basis(i, k) = 0.0;
    for (int64_t unit = begin; unit < end; unit++) {
        for (int64_t i = 0; i < f.free; i++) f.y[i] = i == unit ? 1.0 : 0.0;
        turn_back(f);
        for (int64_t i = 0; i < f.free; i++) basis(whole(f.cable[i]), unit - begin) = f.y[i];
    }
}

// Write N (m, r), from the results of `reduce_to_point`.
template <class T> CDPR_INLINE void complete(const TensionProblem<T>& problem, const Factors<T>& f) {
    const Matrix<T> N = problem.N();
    const int64_t r = f.free - f.rank;
    write_columns(problem, f, f.rank, f.free);
    for (int64_t i = 0; i < problem.m; i++) {
        T longest = 0.0;
        for (int64_t k = 0; k < r; k++) longest = larger(longest, absolute(N(i, k)));
        const Truth<T> still = longest <= T(ROUNDING);
        if (!any(still)) continue;
        for (int64_t k = 0; k < r; k++) N(i, k) = select(still, T(0.0), N(i, k));
    }
}

// Do the same as `reduce` except for N, which `complete` writes if necessary.
template <class T> CDPR_INLINE int64_t reduce_to_point(const TensionProblem<T>& problem, Factors<T>& f) {
    const int64_t rank = factorise(problem, f);
    if (rank < 0) return rank;
    write_center(problem, f);
    return f.free - rank;
}

// Write c and the limits into the box, and N; return r, the redundancy. -INFEASIBLE if W is rank-deficient and the
// wrench outside its range, -NOT_FOUND if tensions exceed the range of numbers, -BAD_INPUT if an entry is not finite or
// a lower limit exceeds the upper one. Lanes have the results of a single problem if `common` holds.
template <class T> CDPR_INLINE int64_t reduce(const TensionProblem<T>& problem) {
    Factors<T> f = factors_of(problem);
    const int64_t r = reduce_to_point(problem, f);
    if (r >= 0) complete(problem, f);
    return r;
}

// The same, compiled once instead of in each solver, which takes long: the call costs some hundredths of a solution.
inline int64_t reduce_once(const TensionProblem<double>& problem) { return reduce(problem); }

// Write W t = wrench as B^T t = B^T c, the orthonormal columns of B (m, k), in place of N; return k, the rank. B spans
// the rows of W, as N their null space; the rest is as in `reduce`.
template <class T> CDPR_INLINE int64_t reduce_to_rows(const TensionProblem<T>& problem) {
    Factors<T> f = factors_of(problem);
    const int64_t rank = factorise(problem, f);
    if (rank < 0) return rank;
    write_columns(problem, f, 0, rank);
    write_center(problem, f);
    return rank;
}

// Return whether lanes had in `reduce`, which returned r, the results of a single problem: full rank, all cables free,
// finite.
template <class T> CDPR_INLINE Truth<T> common(const TensionProblem<T>& problem, int64_t r) {
    if (r < 0 || r != problem.m - problem.n) return false;
    const Factors<T> f = factors_of(problem);
    Truth<T> found = true;
    for (int64_t k = 0; k < f.n; k++) {
        const T norm = absolute(f.diagonal[k]), largest = absolute(f.diagonal[0]);
        found = found & (largest < T(INFINITE)) & (norm > RANK_TOLERANCE * largest);
        found = found & (absolute(f.rhs[k]) < T(TOO_LARGE));
    }
    for (int64_t i = 0; i < problem.m; i++) found = found & (problem.tension_min[i] < problem.tension_max[i]);
    return found;
}

}  // namespace cdpr::CDPR_TARGET
