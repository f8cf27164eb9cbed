// Facets of the set of wrenches that cables can exert, one after the other. SPDX-License-Identifier: Apache-2.0
//
// A normal c of a facet of {W t : low <= t <= high} is orthogonal to n - 1 columns of W (n, m), which span it. So p =
// W^T c is a vector of W's row space that is zero there: an elementary vector, with at most r + 1 entries, r = m - n.
// The shorter description is used: n - 1 columns and the c orthogonal to them (hyperplane shifting: Bouchard, Gosselin
// and Moore, ASME J. Mech. Robot. 2, 2010), or r + 1 cables and the p orthogonal to their rows of the null space N (its
// Gale dual). The cables reach h = sum max(p_i low_i, p_i high_i) along c.
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/matrix.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

enum Mode { MARGIN, CLOSURE, PAYLOAD };           // of `cdpr.analysis.workspace.measure`
enum Required { ZONOTOPE, ELLIPSOID, VERTICES };  // forms of sets of required wrenches

// A normal, of unit vectors, shorter than this belongs to linearly dependent columns, or rows of N: these span no
// facet, or one that others span, too.
constexpr double DEPENDENT = 1e-11;

// Share of the largest term of the margin's difference, below which its sign is round-off: the pose counts as on the
// boundary.
constexpr double MARGIN_ROUNDING = 1e-9;

// Write the next `count` of m numbers, ascending, after those in `index`; return whether there are any.
CDPR_INLINE bool next_subset(int64_t* index, int64_t count, int64_t m) {
    int64_t k = count - 1;
    while (k >= 0 && index[k] == m - count + k) k--;
    if (k < 0) return false;
    index[k]++;
    for (int64_t j = k + 1; j < count; j++) index[j] = index[j - 1] + 1;
    return true;
}

// Write a unit vector x (k + 1) with A[:k] x = 0 by elimination with complete pivoting; return false if there are
// several. A (>= k + 1, >= k + 1) is overwritten; its row k holds the unknown of each column.
inline bool eliminate(Matrix<double> A, int64_t k, double* x) {
    for (int64_t j = 0; j <= k; j++) A(k, j) = double(j);
    for (int64_t step = 0; step < k; step++) {
        int64_t row = step, column = step;
        double largest = 0.0;
        for (int64_t i = step; i < k; i++) {
            for (int64_t j = step; j <= k; j++) {
                if (!(absolute(A(i, j)) > largest)) continue;
                row = i;
                column = j;
                largest = absolute(A(i, j));
            }
        }
        if (!(largest > DEPENDENT)) return false;
        if (row != step)
            for (int64_t j = 0; j <= k; j++) swap(A(step, j), A(row, j));
        if (column != step)
            for (int64_t i = 0; i <= k; i++) swap(A(i, step), A(i, column));
        for (int64_t i = step + 1; i < k; i++) {
            const double factor = A(i, step) / A(step, step);
            for (int64_t j = step; j <= k; j++) A(i, j) -= factor * A(step, j);
        }
    }
    x[whole(A(k, k))] = 1.0;
    double size = 1.0;
    for (int64_t i = k - 1; i >= 0; i--) {
        const double s = difference(-A(i, k), i + 1, k, [&](int64_t j) { return A(i, j) * x[whole(A(k, j))]; });
        const double value = s / A(i, i);
        x[whole(A(k, i))] = value;
        size += value * value;
    }
    size = square_root(size);
    for (int64_t i = 0; i <= k; i++) x[i] /= size;
    return true;
}

// Do the same with rows of length near 1; for up to two rows x is a cross product.
inline bool orthogonal(Matrix<double> A, int64_t k, double* x) {
    if (k > 2) return eliminate(A, k, x);
    if (k == 0) {
        x[0] = 1.0;
        return true;
    }
    if (k == 1) {
        x[0] = -A(0, 1);
        x[1] = A(0, 0);
    } else {
        x[0] = A(0, 1) * A(1, 2) - A(0, 2) * A(1, 1);
        x[1] = A(0, 2) * A(1, 0) - A(0, 0) * A(1, 2);
        x[2] = A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0);
    }
    const double size = square_root(sum(0.0, 0, k + 1, [&](int64_t i) { return x[i] * x[i]; }));
    if (!(size > DEPENDENT)) return false;
    for (int64_t i = 0; i <= k; i++) x[i] /= size;
    return true;
}

// Extent of a required set along a normal, and against it.
template <class T> struct Reach {
    T ahead = 0.0, behind = 0.0;

    // Add number k of the set's vectors, s along the normal.
    CDPR_INLINE void add(int64_t form, int64_t k, T s) {
        if (form == ELLIPSOID) {
            ahead += s * s;
        } else if (form == ZONOTOPE) {
            ahead += absolute(s);
        } else if (k == 0) {
            ahead = s;
            behind = -s;
        } else {
            ahead = larger(ahead, s);
            behind = larger(behind, -s);
        }
    }
    CDPR_INLINE void end(int64_t form) {
        if (form == ELLIPSOID) ahead = square_root(ahead);
        if (form != VERTICES) behind = ahead;
    }
};

// Search among all facets of any robot. Pointers to non-const data are work space.
struct FacetSearch {
    int64_t mode, form, n, m, k, r;
    Matrix<const double> W;         // (n, m)
    Matrix<const double> N;         // (m, r)
    Matrix<const double> required;  // (k, n)
    const double* center;           // (m), c, a solution for the wrench of the weight
    const double* low;              // (m)
    const double* high;             // (m)
    const double* load;             // (n), wrench of 1 kg at the centre of mass
    const int64_t* free;            // (count), cables with tensions that their limits do not determine
    int64_t count;
    int64_t* chosen;         // (n), a subset of those
    Matrix<const double> Y;  // (n, count): c = Y p
    Matrix<double> A;        // (n, n)
    double* x;               // (n)
    double* p;               // (m), of the free cables
    double* c;               // (n)
    double* best;            // (n), of a margin: unit normal of the nearest facet
    // Result so far.
    double least = INFINITE, scale = 0.0;
    double lightest = -INFINITE, heaviest = INFINITE, lightest_scale = 0.0;

    CDPR_INLINE bool dual() const { return r < n - 1; }
    CDPR_INLINE int64_t several() const { return dual() ? r + 1 : n - 1; }
    CDPR_INLINE int64_t entries() const { return dual() ? several() : count; }
    CDPR_INLINE int64_t cable(int64_t i) const { return dual() ? free[chosen[i]] : free[i]; }
    CDPR_INLINE double entry(int64_t i) const { return dual() ? x[i] : p[i]; }

    inline bool find_normal();
    inline void take();
    inline void take_mass(double over, double under, double along, double size, double base, double length);
    inline void take_margin(double over, double under, double along, double size, double base, double length);
    inline void run();
};

// Write the elementary vector of the chosen cables, x, or the normal of their columns, c, and p; return false if they
// are dependent.
inline bool FacetSearch::find_normal() {
    if (dual()) {
        for (int64_t j = 0; j < r; j++)
            for (int64_t i = 0; i < several(); i++) A(j, i) = N(free[chosen[i]], j);
        return orthogonal(A, r, x);
    }
    for (int64_t i = 0; i < several(); i++) {
        const int64_t column = free[chosen[i]];
        const double size = square_root(sum(0.0, 0, n, [&](int64_t j) { return W(j, column) * W(j, column); }));
        for (int64_t j = 0; j < n; j++) A(i, j) = W(j, column) / size;
    }
    if (!orthogonal(A, n - 1, c)) return false;
    for (int64_t i = 0; i < count; i++) p[i] = sum(0.0, 0, n, [&](int64_t j) { return c[j] * W(j, free[i]); });
    for (int64_t i = 0; i < several(); i++) p[chosen[i]] = 0.0;
    return true;
}

// Evaluate a facet with a known normal, and the opposite one.
inline void FacetSearch::take() {
    double base = 0.0, ahead = 0.0, behind = 0.0, size = 0.0, largest = -INFINITE, smallest = INFINITE;
    for (int64_t i = 0; i < entries(); i++) {
        const int64_t at = cable(i);
        const double value = entry(i), up = value * high[at], down = value * low[at];
        base += value * center[at];
        ahead += larger(up, down);
        behind += smaller(up, down);
        size = larger(size, larger(absolute(up), absolute(down)));
        if (dual() || value != 0.0) {
            largest = larger(largest, value);
            smallest = smaller(smallest, value);
        }
    }
    if (mode == CLOSURE) {
        // If p has one sign, it is the effect of a twist that slackens cables and stretches none (Stiemke's lemma).
        least = smaller(least, smaller(largest, -smallest));
        scale = 1.0;
        return;
    }
    if (dual())
        for (int64_t j = 0; j < n; j++)
            c[j] = sum(0.0, 0, several(), [&](int64_t i) { return x[i] * Y(j, chosen[i]); });
    Reach<double> reach;
    for (int64_t v = 0; v < k; v++)
        reach.add(form, v, sum(0.0, 0, n, [&](int64_t j) { return c[j] * required(v, j); }));
    reach.end(form);
    const double length = square_root(sum(0.0, 0, n, [&](int64_t j) { return c[j] * c[j]; }));
    const double over = ahead - base - reach.ahead, under = base - behind - reach.behind;
    if (mode == PAYLOAD)
        take_mass(over, under, reach.ahead, size, base, length);
    else
        take_margin(over, under, reach.ahead, size, base, length);
}

inline void FacetSearch::take_mass(double over, double under, double along, double size, double base, double length) {
    const double pull = sum(0.0, 0, n, [&](int64_t j) { return c[j] * load[j]; });
    const double largest = larger(size, absolute(base)) + along;
    if (absolute(pull) > MARGIN_ROUNDING * length) {
        const double first = over / pull, second = -under / pull;
        const double most = larger(first, second), fewest = smaller(first, second), rounding = largest / absolute(pull);
        if (most < heaviest) {
            heaviest = most;
            scale = rounding;
        }
        if (fewest > lightest) {
            lightest = fewest;
            lightest_scale = rounding;
        }
    } else if (smaller(over, under) < -MARGIN_ROUNDING * largest) {
        heaviest = -INFINITE;
    }
}

inline void FacetSearch::take_margin(double over, double under, double along, double size, double base, double length) {
    const double margin = smaller(over, under) / length;
    if (!(margin < least)) return;
    least = margin;
    scale = (larger(size, absolute(base)) + along) / length;
    for (int64_t j = 0; j < n; j++) best[j] = (over < under ? c[j] : -c[j]) / length;
}

// Evaluate all facets; the result is `least`, for a payload `heaviest`, NaN if the platform itself is too light.
inline void FacetSearch::run() {
    for (int64_t i = 0; i < several(); i++) chosen[i] = i;
    do {
        if (find_normal()) take();
    } while (next_subset(chosen, several(), count));
    if (mode != PAYLOAD) return;
    const bool held = lightest <= MARGIN_ROUNDING * lightest_scale && lightest <= heaviest;
    least = held ? heaviest : NOT_A_NUMBER;
}

}  // namespace cdpr::CDPR_TARGET
