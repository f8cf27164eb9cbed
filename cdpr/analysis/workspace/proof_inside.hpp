// Proof that the cables balance all wrenches everywhere in a box. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/analysis/workspace/proof_box.hpp>

namespace cdpr::CDPR_TARGET {

// Largest distance of W(d) Y from 1: beyond, the remainder grows too large.
constexpr double FAR = 0.5;
// Tensions are searched again once their changes within the box are known.
constexpr int ROUNDS = 2;

// Search for tensions far from the limits, relative to their changes in the box: the largest s with |t_i - limit| >= s
// |T_i| for all cables, by a barrier. Damped Newton steps stay within the constraints of a self-concordant barrier
// (Nesterov and Nemirovskii 1994). The proof is valid for any t.
struct Centre {
    // Smallest distance of a cable from its limits, as a share of them, if its tension does not change.
    static constexpr double LEAST = 1e-9;
    // Steps of the barrier, growth of its weight in each, resulting distance from the optimum, in multiples of the
    // changes of tensions, and the number of these multiples that is enough.
    static constexpr int STEPS = 24;
    static constexpr double FASTER = 2.5, CLOSE = 0.05, ENOUGH = 2.0;

    const Box& box;
    int64_t r;  // columns of N
    double s;
    double weight;

    CDPR_INLINE Matrix<double> L() const { return {box.space.barrier, box.m() + 1}; }

    inline void start();
    inline void add_barrier(int64_t i) const;
    inline bool take_step();
    inline void run();
};

// Begin at the base, and write the change of each cable.
inline void Centre::start() {
    const BoxSpace& space = box.space;
    const double *low = box.low(), *high = box.high();
    s = INFINITE;
    for (int64_t i = 0; i < box.m(); i++) {
        const double* T = box.T()[i];
        space.t[i] = space.base[i];
        space.need[i] = absolute(T[0]) + absolute(T[1]) + absolute(T[2]) + LEAST * (high[i] - low[i]);
        if (low[i] < high[i]) s = smaller(s, smaller(space.t[i] - low[i], high[i] - space.t[i]) / space.need[i]);
    }
    s -= 1.0;
    weight = 2.0 * double(box.m()) / (1.0 + absolute(s));
}

// Add the gradient and the curvature of the barrier of one cable.
inline void Centre::add_barrier(int64_t i) const {
    const double low = box.low()[i], high = box.high()[i], t = box.space.t[i], need = box.space.need[i];
    const double *N = box.N()[i], below = 1.0 / (t - low - s * need), above = 1.0 / (high - t - s * need);
    const double pull = below - above, push = below + above;
    const double curve = below * below + above * above, cross = pull * push;
    double *step = box.space.step, *last = L()[r];
    for (int64_t j = 0; j < r; j++) {
        step[j] += pull * N[j];
        for (int64_t k = 0; k <= j; k++) L()(j, k) += curve * N[j] * N[k];
        last[j] -= cross * need * N[j];
    }
    step[r] -= push * need;
    last[r] += curve * need * need;
}

// Take a damped Newton step; return whether to continue.
inline bool Centre::take_step() {
    const BoxSpace& space = box.space;
    for (int64_t j = 0; j <= r; j++) {
        space.step[j] = j == r ? weight : 0.0;
        for (int64_t k = 0; k <= j; k++) L()(j, k) = 0.0;
    }
    for (int64_t i = 0; i < box.m(); i++)
        if (box.low()[i] < box.high()[i]) add_barrier(i);
    if (!factorise(L(), r + 1, 0.0)) return false;
    solve(L(), space.step, space.a, r + 1);
    const double decrement = sum(0.0, 0, r + 1, [&](int64_t j) { return space.step[j] * space.a[j]; });
    const double share = 1.0 / (1.0 + square_root(larger(decrement, 0.0)));
    s += share * space.a[r];
    for (int64_t i = 0; i < box.m(); i++)
        for (int64_t j = 0; j < r; j++) space.t[i] += share * box.N()(i, j) * space.a[j];
    if (s > ENOUGH) return false;
    weight = smaller(FASTER * weight, 2.0 * double(box.m()) / CLOSE);
    return true;
}

inline void Centre::run() {
    start();
    for (int k = 0; k < STEPS; k++)
        if (!take_step()) return;
}

// Write Y = W^T (W W^T)^-1 of the free cables, zeros for the others; return whether that is possible.
inline bool invert_free(const Box& box) {
    const int64_t n = box.n(), count = box.count, *free = box.free;
    const Matrix<double> W = box.W(), L = box.L(), Y = box.Y();
    for (int64_t j = 0; j < n; j++)
        for (int64_t k = 0; k <= j; k++)
            L(j, k) = sum(0.0, 0, count, [&](int64_t i) { return W(j, free[i]) * W(k, free[i]); });
    if (!factorise(L, n, 0.0)) return false;
    for (int64_t i = 0; i < box.m(); i++)
        for (int64_t j = 0; j < n; j++) Y(i, j) = 0.0;
    for (int64_t i = 0; i < count; i++) {
        for (int64_t j = 0; j < n; j++) box.space.a[j] = W(j, free[i]);
        solve(L, box.space.a, Y[free[i]], n);
    }
    return true;
}

// Return an upper bound of |W(d) Y - 1|: the largest sum of absolute values in a row.
inline double distance_from_one(const Box& box) {
    double worst = 0.0;
    for (int64_t j = 0; j < box.n(); j++) {
        double total = 0.0;
        for (int64_t k = 0; k < box.n(); k++) {
            Model e = {j == k ? -1.0 : 0.0, 0.0, 0.0, 0.0, 0.0};
            for (int64_t i = 0; i < box.m(); i++) e = e + box.Y()(i, k) * model(box.entry(i, j));
            total += e.largest();
        }
        worst = larger(worst, total * (1.0 + ROUNDED));
        if (!(total < INFINITE)) return INFINITE;
    }
    return worst;
}

// Write T = -Y dW t.
inline void write_rates(const Box& box) {
    const int64_t n = box.n(), m = box.m();
    double* a = box.space.a;
    for (int k = 0; k < 3; k++) {
        for (int64_t j = 0; j < n; j++)
            a[j] = sum(0.0, 0, m, [&](int64_t i) { return box.entry(i, j)[1 + k] * box.space.t[i]; });
        for (int64_t i = 0; i < m; i++)
            box.T()(i, k) = difference(0.0, 0, n, [&](int64_t j) { return box.Y()(i, j) * a[j]; });
    }
}

// Return an upper bound of W(d) t(d) - wrench.
inline double largest_rest(const Box& box, const double* wrench, double error) {
    double rest = 0.0;
    for (int64_t j = 0; j < box.n(); j++) {
        Model s = {-wrench[j], 0.0, 0.0, 0.0, error};
        for (int64_t i = 0; i < box.m(); i++) {
            const double* T = box.T()[i];
            s = s + model(box.entry(i, j)) * Model{box.space.t[i], T[0], T[1], T[2], 0.0};
        }
        rest = larger(rest, s.largest());
        if (!(rest < INFINITE)) return INFINITE;
    }
    return rest;
}

// Return whether cable i stays within its limits, if y is at most `rest`.
inline bool stays_within(const Box& box, int64_t i, double rest) {
    const double low = box.low()[i], high = box.high()[i], t = box.space.t[i], *T = box.T()[i];
    double moved = sum(0.0, 0, box.n(), [&](int64_t j) { return absolute(box.Y()(i, j)); });
    moved = moved * rest + absolute(T[0]) + absolute(T[1]) + absolute(T[2]);
    moved = moved * (1.0 + 16.0 * ROUNDED) + ROUNDED * (absolute(t) + absolute(low) + absolute(high));
    if (low == high) return t == low && moved <= 2.0 * ROUNDED * (absolute(t) + absolute(low) + absolute(high));
    return t - low >= moved && high - t >= moved;
}

// Return whether t + T d, with the remainder balanced by Y y, is within the limits at all d.
inline bool holds(const Box& box, const double* wrench, double error, double far) {
    double rest = largest_rest(box, wrench, error);
    if (!(rest < INFINITE)) return false;
    rest /= 1.0 - far;
    for (int64_t i = 0; i < box.m(); i++)
        if (!stays_within(box, i, rest)) return false;
    return true;
}

// Return whether all wrenches (count, n), known to within `error`, are feasible everywhere in the box.
inline bool proved_inside(const Box& box, const double* wrenches, int64_t count, double error) {
    const int64_t n = box.n(), r = box.count - n;
    const BoxSpace& space = box.space;
    if (!invert_free(box)) return false;
    const double far = distance_from_one(box);
    if (!(far < FAR)) return false;
    for (int64_t w = 0; w < count; w++) {
        const double* wrench = wrenches + n * w;
        for (int64_t i = 0; i < box.m(); i++) {
            space.base[i] = sum(box.at_middle.box[i], 0, n,
                                [&](int64_t j) { return box.Y()(i, j) * (wrench[j] - box.at_middle.wrench[j]); });
            space.t[i] = space.base[i];
        }
        write_rates(box);
        for (int k = 0; k < (r > 0 ? ROUNDS : 0); k++) {
            Centre{box, r, 0.0, 0.0}.run();
            write_rates(box);
        }
        if (!holds(box, wrench, error, far)) return false;
    }
    return true;
}

}  // namespace cdpr::CDPR_TARGET
