// Checks of a tension distribution, independent of its solver. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/lanes.hpp>
#include <cdpr/status.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

// A tension is within its limits, or at a limit, to this many newtons; on robots with limits below one newton, to this
// share of the largest limit: finer than any force sensor, coarser than the round-off of every exact solver.
constexpr double LIMIT_TOLERANCE = 1e-6;

// A distribution balances the wrench if the residual is below this share of it, or of a newton: below any model error,
// and above what first-order solvers reach when they report convergence.
constexpr double RESIDUAL_TOLERANCE = 1e-6;

// Squares of numbers beyond 1e154 are infinite: those of such wrenches are taken in units so large that none overflows.
constexpr double FAR_UNIT = 0x1p-520;

// Limits of the cables.
template <class T> struct Limits {
    const T* low;   // (m), N
    const T* high;  // (m), N
    int64_t m;
};

// Return the scale of the tolerances, N: one newton, or the largest limit if that is less, for robots that are held by
// millinewtons; 1 if all limits are zero.
template <class T> CDPR_INLINE T newton(Limits<T> limits) {
    T largest = 0.0;
    for (int64_t i = 0; i < limits.m; i++)
        largest = larger(largest, larger(absolute(limits.low[i]), absolute(limits.high[i])));
    return select((largest >= T(1.0)) | !(largest > T(0.0)), T(1.0), largest);
}

// Margin of tensions to the nearest limit, N, and number of cables at a limit.
template <class T> struct Margin {
    T least, at_limit;
};

// Return the margin of tensions (m). A locked cable (equal limits) counts only if it does not have that tension. Cables
// whose `held` (m), if given, is not NaN are broken or jammed and do not count.
template <class T> CDPR_INLINE Margin<T> margin_of(Limits<T> limits, const T* tension, const T* held, T tolerance) {
    Margin<T> margin = {INFINITE, 0.0};
    for (int64_t i = 0; i < limits.m; i++) {
        const T low = limits.low[i], high = limits.high[i];
        const T distance = smaller(tension[i] - low, high - tension[i]);
        Truth<T> aside = (low == high) & (distance >= -tolerance);
        if (held) aside = aside | (held[i] == held[i]);
        margin.least = select(aside, margin.least, smaller(margin.least, distance));
        margin.at_limit += select(aside, T(0.0), select(distance <= tolerance, T(1.0), T(0.0)));
    }
    return margin;
}

// Check of a solver's answer.
template <class T> struct Acceptance {
    const T* matrix;   // (n, m), moments in N m per N
    const T* wrench;   // (n), N and N m
    const T* weights;  // (n), 1 for forces, 1 / characteristic length, 1/m, for moments
    const T* limits;   // (2, m), N
    const T* answer;   // (m), N, of a solver
    T* tension;        // (m), N: the answer within the limits; unchanged unless accepted
    T* report;         // (4): status; residual, N; margin, N; number of cables at a limit; the last three unchanged if
                       // an entry is not finite
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), weights(n), limits(2, m), answer(m), both tension(m), both report(4), n, m";

    CDPR_INLINE Limits<T> bounds() const { return {limits, limits + m, m}; }
};

// Write the squares of the weighted residual and of the wrench, in a unit.
template <class T> CDPR_INLINE void squares(const Acceptance<T>& problem, T unit, T& residual, T& load) {
    residual = 0.0;
    load = 0.0;
    for (int64_t j = 0; j < problem.n; j++) {
        const T* row = problem.matrix + j * problem.m;
        const T s = sum(-problem.wrench[j], 0, problem.m, [&](int64_t i) { return row[i] * problem.answer[i]; });
        const T lack = unit * problem.weights[j] * s, wanted = unit * problem.weights[j] * problem.wrench[j];
        residual += lack * lack;
        load += wanted * wanted;
    }
}

// Return whether a finite answer is within the limits and balances the wrench; write the report for the lanes that are
// finite. `held` cables count as in `margin_of`.
template <class T> CDPR_INLINE Truth<T> holds(Acceptance<T>& problem, Truth<T> sound, const T* held = nullptr) {
    T unit = 1.0, residual, load;
    squares(problem, unit, residual, load);
    const Truth<T> summed = (residual < T(INFINITE)) & (load < T(INFINITE));
    if (!all(summed)) {
        unit = select(summed, unit, T(FAR_UNIT));
        squares(problem, unit, residual, load);
    }
    const T one = newton(problem.bounds()), tolerance = LIMIT_TOLERANCE * one;
    const Margin<T> margin = margin_of(problem.bounds(), problem.answer, held, tolerance);
    const T missed = square_root(residual) / unit;
    const T allowed = RESIDUAL_TOLERANCE * larger(one, square_root(load) / unit);
    problem.report[1] = select(sound, missed, problem.report[1]);
    problem.report[2] = select(sound, margin.least, problem.report[2]);
    problem.report[3] = select(sound, margin.at_limit, problem.report[3]);
    return (margin.least >= -tolerance) & (missed <= allowed) & (allowed < T(INFINITE));
}

// Copy a solver's answer if it is finite, within the limits and balances the wrench. Return the status: OK, BAD_INPUT
// if the wrench is not finite, else NOT_FOUND; for lanes, the bits of those that are not OK.
template <class T> inline int accept(Acceptance<T>& problem) {
    const T answered = sum(T(0.0), 0, problem.m, [&](int64_t i) { return 0.0 * problem.answer[i]; });
    const T asked = sum(T(0.0), 0, problem.n, [&](int64_t j) { return 0.0 * problem.wrench[j]; });
    const Truth<T> given = asked == T(0.0), sound = given & (answered == T(0.0));
    Truth<T> right = sound;
    if (any(sound)) {
        right = sound & holds(problem, sound);
        const Limits<T> limits = problem.bounds();
        for (int64_t i = 0; i < problem.m; i++) {
            const T within = smaller(larger(problem.answer[i], limits.low[i]), limits.high[i]);
            problem.tension[i] = select(right, within, problem.tension[i]);
        }
    }
    const T status = select(right, T(double(OK)), select(given, T(double(NOT_FOUND)), T(double(BAD_INPUT))));
    problem.report[0] = status;
    return code(status);
}

}  // namespace cdpr::CDPR_TARGET
