// Tensions imposed on cables after the distribution. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/checks.hpp>

namespace cdpr::CDPR_TARGET {

// Set the tensions of `held` cables, N; NaN for free cables.
template <class T> CDPR_INLINE void hold(const T* held, T* tension, int64_t m) {
    for (int64_t i = 0; i < m; i++) tension[i] = select(held[i] == held[i], held[i], tension[i]);
}

template <class T> struct Imposed {
    const T* held;     // (m), N, NaN for free cables
    const T* matrix;   // (n, m), moments in N m per N
    const T* wrench;   // (n), N and N m
    const T* weights;  // (n), 1 for forces, 1 / characteristic length, 1/m, for moments
    const T* limits;   // (2, m), N
    T* tension;        // (m), N
    T* report;         // (4), as in Acceptance; its status stays that of the distribution
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "held(m), matrix(n, m), wrench(n), weights(n), limits(2, m), both tension(m), both report(4), n, m";
};

// Set held tensions, and write the report of all tensions.
template <class T> inline int impose_tensions(Imposed<T>& p) {
    hold(p.held, p.tension, p.m);
    Acceptance<T> judged = {p.matrix, p.wrench, p.weights, p.limits, p.tension, p.tension, p.report, p.n, p.m};
    holds(judged, Truth<T>(true), p.held);
    return OK;
}

// Distance of the tensions from their limits.
template <class T> struct Room {
    const T* limits;   // (2, m), N
    const T* tension;  // (m), N
    const T* held;     // (m), N, NaN for free cables
    T* room;           // (m), N, to the nearer limit, negative beyond; NaN for held cables
    int64_t m;
    static constexpr char fields[] = "limits(2, m), tension(m), held(m), room(m), m";
};

template <class T> inline int room_within_limits(Room<T>& p) {
    for (int64_t i = 0; i < p.m; i++) {
        const T distance = smaller(p.tension[i] - p.limits[i], p.limits[p.m + i] - p.tension[i]);
        p.room[i] = select(p.held[i] == p.held[i], T(NOT_A_NUMBER), distance);
    }
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
