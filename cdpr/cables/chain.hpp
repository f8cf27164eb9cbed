// Tensions and winches of the cables of one robot. SPDX-License-Identifier: Apache-2.0
//
// A cable consists of a winch, an exit and a span (`cdpr.cables`). A row of `chains` holds: kinds of winch and span
// (parts.hpp); the lowest tension, N: 0, or minus infinity for a leg that pushes; eight numbers of the winch, the first
// of which is cable per unit of the winch's coordinate, m/rad; eight numbers of the span.
#pragma once

#include <cdpr/cables/parts.hpp>
#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct ChainRow {
    static constexpr int WINCH_KIND = 0, SPAN_KIND = 1, LOWEST = 2, WINCH = 3, SPAN = 11, WIDTH = 19;

    const T* row;

    CDPR_INLINE T winch_kind() const { return row[WINCH_KIND]; }
    CDPR_INLINE T span_kind() const { return row[SPAN_KIND]; }
    CDPR_INLINE bool stretches() const { return !is(span_kind(), INEXTENSIBLE); }
    CDPR_INLINE T lowest() const { return row[LOWEST]; }
    CDPR_INLINE T per_turn() const { return row[WINCH]; }
    CDPR_INLINE const T* winch() const { return row + WINCH; }
    CDPR_INLINE const T* span() const { return row + SPAN; }
};

template <class T> CDPR_INLINE ChainRow<T> chain_row(const T* chains, int64_t i) {
    return {chains + i * ChainRow<T>::WIDTH};
}

// The next three are compiled into exported FMUs (cdpr/fmu/export/source/actuator.cpp).

// Tensions of all cables.
template <class T> struct ChainTensions {
    const T* chains;               // (m, 19)
    const T* command;              // (m), N: static tension of the winch
    const T* length;               // (m), m, between winch and platform
    const T* rate;                 // (m), m/s, rate of the length
    const T* length_acceleration;  // (m), m/s^2, rate of that rate for a platform without acceleration
    const T* unwound;              // (m), m, unstretched length, of cables that stretch
    const T* speed;                // (m), rad/s, of their winches, positive when winding in
    T* tension;                    // (m), N, without the effect of the winches' inertia at an accelerating platform
    T* mass;                       // (m), kg, that inertia as a mass along the cable
    int64_t m;
};

template <class T> inline int chain_tensions(ChainTensions<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        WinchTension<T> own;
        if (row.stretches()) {
            const T stretching = cables.rate[i] + row.per_turn() * cables.speed[i];
            own = {pull(row.span_kind(), row.span(), cables.length[i], cables.unwound[i], stretching, row.lowest()),
                   0.0};
        } else {
            own = held(row.winch_kind(), row.winch(), cables.command[i], cables.rate[i], cables.length_acceleration[i]);
        }
        cables.tension[i] = own.tension;
        cables.mass[i] = own.mass;
    }
    return 0;
}

// Time derivatives of winches with elastic cables; 0 for others.
template <class T> struct ChainSlopes {
    const T* chains;   // (m, 19)
    const T* command;  // (m), N
    const T* tension;  // (m), N
    const T* speed;    // (m), rad/s
    T* unwinding;      // (m), m/s, rate of the unwound length
    T* acceleration;   // (m), rad/s^2
    int64_t m;
};

template <class T> inline int chain_slopes(ChainSlopes<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        const T speed = cables.speed[i];
        cables.unwinding[i] = row.stretches() ? -row.per_turn() * speed : T(0.0);
        cables.acceleration[i] = row.stretches() ? drum_acceleration(row.winch_kind(), row.winch(), cables.command[i],
                                                                     cables.tension[i], speed)
                                                 : T(0.0);
    }
    return 0;
}

// Start of winches with elastic cables: each tension is its command, with constant stretch; 0 for others.
template <class T> struct ChainStart {
    const T* chains;   // (m, 19)
    const T* command;  // (m), N
    const T* length;   // (m), m
    const T* rate;     // (m), m/s
    T* unwound;        // (m), m
    T* speed;          // (m), rad/s
    int64_t m;
};

template <class T> inline int chain_start(ChainStart<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        cables.unwound[i] =
            row.stretches() ? rest(row.span_kind(), row.span(), cables.length[i], cables.command[i]) : T(0.0);
        cables.speed[i] = row.stretches() ? -cables.rate[i] / row.per_turn() : T(0.0);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
