// Minimum of a logarithmic barrier by Newton's method. SPDX-License-Identifier: Apache-2.0
//
// Boyd and Vandenberghe, Convex Optimization (2004), sections 8.5.3 and 9.6.
#pragma once

#include <cdpr/tension/factors.hpp>
#include <cdpr/tension/null_space.hpp>

namespace cdpr::CDPR_TARGET {

// Newton decrement, a length relative to the distance from the limits, below which the full step is the last one: with
// quadratic convergence the error after it is about the square, which is round-off.
constexpr double BARRIER_CONVERGED = 1e-8;

// Below this decrement the full Newton step stays within the limits and converges quadratically (self-concordance).
constexpr double BARRIER_FULL_STEP = 0.25;

// Steps that no regular problem needs: ten are typical, from the centre of the largest ball.
constexpr int BARRIER_MOST_STEPS = 200;

// Factor by which a damped step grows along a long, thin set, as long as the barrier decreases there. A power of two is
// exact, and reaches the end of the range of doubles in 2100 steps.
constexpr double BARRIER_GROWTH = 2.0;

// Below this decrement one that is not half of the previous one is round-off: no further improvement is possible.
constexpr double BARRIER_NOISE = 1e-3, BARRIER_SHRINKING = 0.5;

// -sum w_i [log(c_i + N_i x - low_i) + log(high_i - c_i - N_i x)].
struct Barrier {
    Matrix<double> N;       // (m + 1, r): N, and x as its last row
    const double* c;        // (m), N, within the limits
    const double* low;      // (m), N
    const double* high;     // (m), N
    const double* weights;  // (m), w
    double* x;              // (r)
    Matrix<double> H;       // (r, r), work space: the Hessian, then its factor L
    double* step;           // (r), work space: Newton's
    int64_t m, r;

    CDPR_INLINE double change(int64_t i, const double* by) const {
        return sum(0.0, 0, r, [&](int64_t a) { return N(i, a) * by[a]; });
    }
    CDPR_INLINE double below(int64_t i) const { return c[i] - low[i]; }
    CDPR_INLINE double above(int64_t i) const { return high[i] - c[i]; }

    // Rotate the basis, and x with it, so that its first columns are the directions with the nearest limits.
    inline void align() const {
        for (int64_t k = 0; k < r - 1; k++) {
            int64_t nearest = -1;
            double closest = 0.0, size = 0.0;
            for (int64_t i = 0; i < m; i++) {
                const double s = change(i, x);
                const double length = square_root(sum(0.0, k, r, [&](int64_t a) { return N(i, a) * N(i, a); }));
                // The remainder of a row after the previous rotations may be their round-off.
                if (!(length > ROUNDING)) continue;
                const double rate = length / smaller(below(i) + s, above(i) - s);
                if (rate > closest) {
                    nearest = i;
                    closest = rate;
                    size = length;
                }
            }
            if (nearest < 0) return;
            turn(N, m + 1, r, k, nearest, size, step);
        }
    }

    // Write the negative gradient as the step, and the lower half of the Hessian.
    inline void differentiate() const {
        for (int64_t a = 0; a < r; a++) {
            step[a] = 0.0;
            for (int64_t b = 0; b <= a; b++) H(a, b) = 0.0;
        }
        for (int64_t i = 0; i < m; i++) {
            if (!(sum(0.0, 0, r, [&](int64_t a) { return absolute(N(i, a)); }) > 0.0)) continue;
            const double s = change(i, x), lower = 1.0 / (below(i) + s), upper = 1.0 / (above(i) - s);
            const double slope = weights[i] * (upper - lower);
            const double bend = weights[i] * (lower * lower + upper * upper);
            for (int64_t a = 0; a < r; a++) {
                step[a] -= slope * N(i, a);
                for (int64_t b = 0; b <= a; b++) H(a, b) += bend * N(i, a) * N(i, b);
            }
        }
    }

    // Replace the negative gradient by the Newton step; return the square of its decrement.
    inline double write_step() const {
        double square = 0.0;
        for (int64_t a = 0; a < r; a++) {
            for (int64_t b = 0; b <= a; b++) {
                const double s = difference(H(a, b), 0, b, [&](int64_t k) { return H(a, k) * H(b, k); });
                H(a, b) = a == b ? square_root(s) : s / H(b, b);
            }
            step[a] = difference(step[a], 0, a, [&](int64_t k) { return H(a, k) * step[k]; }) / H(a, a);
            square += step[a] * step[a];
        }
        for (int64_t a = r - 1; a >= 0; a--)
            step[a] = difference(step[a], a + 1, r, [&](int64_t k) { return H(k, a) * step[k]; }) / H(a, a);
        return square;
    }

    // Return whether x + length step is within the limits and the barrier still decreases there along the step.
    inline bool downhill(double length) const {
        double slope = 0.0;
        for (int64_t i = 0; i < m; i++) {
            const double s = change(i, x), v = change(i, step);
            if (v == 0.0) continue;
            const double lower = below(i) + s + length * v, upper = above(i) - s - length * v;
            if (!(lower > 0.0 && upper > 0.0)) return false;
            slope += weights[i] * (v / upper - v / lower);
        }
        return slope < 0.0;
    }

    // Return the length of the damped Newton step.
    inline double damped(double decrement) const {
        if (!(decrement > BARRIER_FULL_STEP)) return 1.0;
        double length = 1.0 / (1.0 + decrement);  // within the limits, and lower, by theory
        while (downhill(BARRIER_GROWTH * length)) length *= BARRIER_GROWTH;
        return length;
    }

    // Move x from inside the limits to the minimum; return whether it was reached.
    inline bool minimise(bool flat) const {
        double lightest = INFINITE, previous = INFINITE;
        for (int64_t i = 0; i < m; i++) lightest = smaller(lightest, weights[i]);
        for (int trial = 0; trial < BARRIER_MOST_STEPS; trial++) {
            if (flat) align();
            differentiate();
            // Decrement of the barrier scaled so that its smallest weight is 1.
            const double decrement = square_root(write_step() / lightest);
            if (!(decrement < INFINITE)) return false;  // NaN, too
            const double length = damped(decrement);
            for (int64_t a = 0; a < r; a++) x[a] += length * step[a];
            if (decrement <= BARRIER_CONVERGED) return true;
            if (decrement <= BARRIER_NOISE && decrement > BARRIER_SHRINKING * previous) return true;
            previous = decrement;
        }
        return false;
    }
};

}  // namespace cdpr::CDPR_TARGET
