// Proof that a wrench is beyond a facet everywhere in a box. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/analysis/workspace/proof_box.hpp>

namespace cdpr::CDPR_TARGET {

// Share of the largest diagonal by which possibly singular systems are damped: their results are verified afterwards.
constexpr double PROOF_DAMPING = 1e-12;

// Choose the cables with columns nearest to perpendicular to c, at most n - 1; return their number.
inline int64_t choose_square(const Box& box) {
    const int64_t n = box.n(), count = box.count;
    const Matrix<double> W = box.W();
    double* size = box.space.a;
    for (int64_t i = 0; i < count; i++) {
        const int64_t f = box.free[i];
        size[i] = absolute(sum(0.0, 0, n, [&](int64_t j) { return box.at_middle.best[j] * W(j, f); }));
        box.chosen[i] = f;
    }
    const int64_t several = n - 1 < count ? n - 1 : count;
    for (int64_t k = 0; k < several; k++) {
        int64_t least = k;
        for (int64_t i = k + 1; i < count; i++)
            if (size[i] < size[least]) least = i;
        const double other = size[k];
        const int64_t cable = box.chosen[k];
        size[k] = size[least];
        size[least] = other;
        box.chosen[k] = box.chosen[least];
        box.chosen[least] = cable;
    }
    return several;
}

// Write the factor of c c^T + W W^T of the chosen cables; return whether it is regular.
inline bool factorise_chosen(const Box& box, int64_t several) {
    const int64_t n = box.n();
    const double* c = box.at_middle.best;
    const Matrix<double> W = box.W(), L = box.L();
    double size = 1.0;
    for (int64_t j = 0; j < n; j++) {
        for (int64_t k = 0; k <= j; k++)
            L(j, k) =
                sum(c[j] * c[k], 0, several, [&](int64_t i) { return W(j, box.chosen[i]) * W(k, box.chosen[i]); });
        size = larger(size, L(j, j));
    }
    for (int64_t j = 0; j < n; j++) L(j, j) += PROOF_DAMPING * size;
    return factorise(L, n, 0.0);
}

// Write G, for which c(d) . W_i(d) is constant to first order for the n - 1 cables with the smallest value.
inline void follow_facet(const Box& box) {
    const int64_t n = box.n(), several = choose_square(box);
    const double* c = box.at_middle.best;
    const Matrix<double> W = box.W(), G = box.G();
    const bool regular = factorise_chosen(box, several);
    double *a = box.space.a, *b = box.space.b;
    for (int k = 0; k < 3; k++) {
        for (int64_t j = 0; j < n; j++) b[j] = 0.0;
        for (int64_t i = 0; i < several; i++) {
            const int64_t f = box.chosen[i];
            const double s = sum(0.0, 0, n, [&](int64_t j) { return c[j] * box.entry(f, j)[1 + k]; });
            for (int64_t j = 0; j < n; j++) b[j] -= s * W(j, f);
        }
        if (regular) solve(box.L(), b, a, n);
        for (int64_t j = 0; j < n; j++) G(j, k) = regular ? a[j] : 0.0;
    }
}

// Return the number of the wrench with the largest component along c.
inline int64_t farthest_wrench(const Box& box, const double* wrenches, int64_t count) {
    const int64_t n = box.n();
    int64_t worst = 0;
    double farthest = -INFINITE;
    for (int64_t w = 0; w < count; w++) {
        const double reached = sum(0.0, 0, n, [&](int64_t j) { return box.at_middle.best[j] * wrenches[w * n + j]; });
        if (!(reached > farthest)) continue;
        worst = w;
        farthest = reached;
    }
    return worst;
}

// Return whether one of the wrenches (count, n), known to within `error`, is beyond a facet everywhere in the box.
inline bool proved_outside(const Box& box, const double* wrenches, int64_t count, double error) {
    const int64_t n = box.n(), m = box.m();
    const double *low = box.low(), *high = box.high();
    follow_facet(box);
    const double* worst = wrenches + n * farthest_wrench(box, wrenches, count);
    const auto along = [&](int64_t j) -> Model {
        return {box.at_middle.best[j], box.G()(j, 0), box.G()(j, 1), box.G()(j, 2), 0.0};
    };
    Model total = {0.0, 0.0, 0.0, 0.0, 0.0};
    double rest = 0.0;
    for (int64_t j = 0; j < n; j++) total = total + along(j) * Model{-worst[j], 0.0, 0.0, 0.0, error};
    for (int64_t i = 0; i < m; i++) {
        Model s = {0.0, 0.0, 0.0, 0.0, 0.0};
        for (int64_t j = 0; j < n; j++) s = s + along(j) * model(box.entry(i, j));
        if (absolute(s.c) > (s.spread() + s.r) * (1.0 + ROUNDED)) {
            total = total + (s.c > 0.0 ? high[i] : low[i]) * s;
        } else {
            const double middle = 0.5 * (low[i] + high[i]);
            total = total + middle * s;
            rest += larger(high[i] - middle, middle - low[i]) * (1.0 + ROUNDED) * s.largest();
        }
    }
    return total.c + (total.spread() + total.r + rest) * (1.0 + 16.0 * ROUNDED) < -ROUNDED * absolute(total.c);
}

}  // namespace cdpr::CDPR_TARGET
