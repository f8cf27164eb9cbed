// Bent cables with given ends. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/chain.hpp>

namespace cdpr::CDPR_TARGET {

// Forces and tensions of cables with given unwound lengths.
template <class T> struct BentCables {
    const T* chains;          // (m, 33), chain.hpp
    const T* gravity;         // (3), m/s^2
    const T* chord;           // (m, 3), m, from the platform to the exit, world axes
    const T* exit_to_anchor;  // (m, 3), m, over the exit
    const T* wrapped_length;  // (m), m, of cable on the exit
    const T* unwound;         // (m), m
    const T* stretching;      // (m), m/s, rate of stretch
    T* force;                 // (m, 3), N, on the platform
    T* tension;               // (m), N, at the winch
    int64_t m;
    static constexpr char fields[] =
        "chains(m, 33), gravity(3), chord(m, 3), exit_to_anchor(m, 3), wrapped_length(m), unwound(m), stretching(m), "
        "force(m, 3), tension(m), m";
};

template <class T> inline int bent_cables(BentCables<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        const BentSpan<T> span = {row.span(), vector(cables.chord + 3 * i), cables.wrapped_length[i],
                                  vector(cables.gravity), vector(cables.exit_to_anchor + 3 * i)};
        const BentCable<T> end =
            bent_pull(row.span_kind(), span, cables.unwound[i], cables.stretching[i], row.lowest());
        store(end.force, cables.force + 3 * i);
        cables.tension[i] = end.tension;
    }
    return 0;
}

// Unwound lengths of cables with given tensions at their winches.
template <class T> struct BentLengths {
    const T* chains;          // (m, 33)
    const T* gravity;         // (3), m/s^2
    const T* chord;           // (m, 3), m
    const T* exit_to_anchor;  // (m, 3), m
    const T* wrapped_length;  // (m), m
    const T* tension;         // (m), N
    T* unwound;               // (m), m
    int64_t m;
    static constexpr char fields[] =
        "chains(m, 33), gravity(3), chord(m, 3), exit_to_anchor(m, 3), wrapped_length(m), tension(m), unwound(m), m";
};

template <class T> inline int bent_lengths(BentLengths<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        const BentSpan<T> span = {row.span(), vector(cables.chord + 3 * i), cables.wrapped_length[i],
                                  vector(cables.gravity), vector(cables.exit_to_anchor + 3 * i)};
        cables.unwound[i] = bent_rest(row.span_kind(), span, cables.tension[i]);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
