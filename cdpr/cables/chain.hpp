// Tensions and winches of the cables of one robot. SPDX-License-Identifier: Apache-2.0
//
// A cable consists of a winch, an exit and a span (`cdpr.cables`). A row of `chains` holds: kinds of winch and span
// (parts.hpp); the lowest tension, N: 0, or minus infinity for a leg that pushes; twelve numbers of the winch, the
// first of which is cable per unit of the winch's coordinate at the home pose, m/rad; six numbers of the transmission
// (transmission.hpp); twelve numbers of the span.
#pragma once

#include <cdpr/cables/parts.hpp>
#include <cdpr/cables/transmission.hpp>
#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct ChainRow {
    static constexpr int WINCH_KIND = 0, SPAN_KIND = 1, LOWEST = 2, WINCH = 3, TRANSMISSION = 15, SPAN = 21, WIDTH = 33;
    static constexpr int NUMBERS = TRANSMISSION - WINCH;  // of a winch

    const T* row;

    CDPR_INLINE T winch_kind() const { return row[WINCH_KIND]; }
    CDPR_INLINE T span_kind() const { return row[SPAN_KIND]; }
    CDPR_INLINE bool stretches() const { return !is(span_kind(), INEXTENSIBLE); }
    CDPR_INLINE T lowest() const { return row[LOWEST]; }
    CDPR_INLINE const T* transmission() const { return row + TRANSMISSION; }
    CDPR_INLINE const T* span() const { return row + SPAN; }

    // Return the cable per unit of the winch's coordinate, m/rad, with an unwound length, m; 0 without a winch.
    CDPR_INLINE T per_turn(T unwound) const {
        if (!Transmission::converts(transmission())) return row[WINCH];
        return Transmission::per_turn(transmission(), row[WINCH], unwound);
    }

    // Return the angle of the drum with an unwound length, m: 0 at the home pose, rad.
    CDPR_INLINE T angle(T unwound) const { return Transmission::angle(transmission(), row[WINCH], unwound); }

    // Return the numbers of the winch with an unwound length, m. `present` (NUMBERS) holds them if they depend on that.
    CDPR_INLINE const T* winch(T unwound, T* present) const {
        if (!Transmission::converts(transmission())) return row + WINCH;
        present[0] = per_turn(unwound);
        for (int j = 1; j < NUMBERS; j++) present[j] = row[WINCH + j];
        return present;
    }

    // Return the tension that a winch with an ideal transmission needs to move a cable with this tension, N.
    CDPR_INLINE T load(T tension, T speed) const { return tension * Transmission::load(transmission(), speed); }

    // Return tension and mass of a winch whose cable does not stretch; `own` are the winch's own state numbers. The
    // cable has this length, m, and rate, m/s, and this acceleration, m/s^2, for a platform without acceleration.
    CDPR_INLINE WinchTension<T> held(const T* own, T command, T length, T rate, T acceleration) const {
        if (is(winch_kind(), DIRECT)) return Direct::held(row + WINCH, command, rate, acceleration);
        T present[NUMBERS];
        const T *numbers = winch(length, present), *line = transmission(), turned = numbers[0];
        if (any(line[Transmission::GROWTH] != T(0.0)))  // a drum that becomes smaller turns faster
            acceleration = acceleration + Transmission::quickening(line, turned) * rate * rate;
        WinchTension<T> found = cdpr::held(winch_kind(), numbers, own, command, rate, acceleration);
        if (!any(line[Transmission::EFFICIENCY] != T(1.0))) return found;
        const T load = Transmission::load(line, -rate / turned);
        return {found.tension / load, found.mass / load};
    }
};

template <class T> CDPR_INLINE ChainRow<T> chain_row(const T* chains, int64_t i) {
    return {chains + i * ChainRow<T>::WIDTH};
}

// Return the unwound length, m, of a span that stretches, at rest with a tension, N, at its winch. `length`: of its
// path from the platform to the winch, m; `ends`: used by spans that bend.
template <class T> CDPR_INLINE T unwound_length(ChainRow<T> row, const BentSpan<T>& ends, T length, T tension) {
    const T kind = row.span_kind();
    return bends(kind) ? bent_rest(kind, ends, tension) : rest(kind, row.span(), length, tension);
}

// Return the tension, N, at the winch of a span that stretches, at rest with this unwound length, m.
template <class T> CDPR_INLINE T tension_at(ChainRow<T> row, const BentSpan<T>& ends, T length, T unwound) {
    const T kind = row.span_kind(), still = 0.0;
    if (bends(kind)) return bent_pull(kind, ends, unwound, still, row.lowest()).tension;
    return pull_at_rest(kind, row.span(), length, unwound, row.lowest());
}

// State numbers of all winches, cable by cable: of a cable that stretches the unwound length, m, and the speed of its
// winch, rad/s, positive when winding in; then the winch's own, then those of the span.
template <class T> struct WinchStates {
    static constexpr int COORDINATE = 2;  // numbers of the first kind

    T* numbers;             // (s)
    const int64_t* places;  // (m + 1), of each winch in `numbers`, and s

    CDPR_INLINE T& unwound(int64_t i) const { return numbers[places[i]]; }
    CDPR_INLINE T& speed(int64_t i) const { return numbers[places[i] + 1]; }
    CDPR_INLINE int64_t own_place(int64_t i, bool stretches) const { return places[i] + (stretches ? COORDINATE : 0); }
    CDPR_INLINE T* own(int64_t i, bool stretches) const { return numbers + own_place(i, stretches); }
    CDPR_INLINE int64_t own_count(int64_t i, ChainRow<T> row) const {
        return places[i + 1] - own_place(i, row.stretches()) - span_states(row.span_kind());
    }
    CDPR_INLINE T* of_span(int64_t i, ChainRow<T> row) const {
        return numbers + (places[i + 1] - span_states(row.span_kind()));
    }

    // Return the motion of a span that stretches, with this length, m, and rate, m/s.
    CDPR_INLINE SpanMotion<T> span(int64_t i, ChainRow<T> row, T length, T rate) const {
        const T unwound = this->unwound(i), wound = row.per_turn(unwound) * speed(i);
        return {row.span(), of_span(i, row), length, unwound, -wound, rate + wound};
    }
};

// The next three are compiled into exported FMUs (cdpr/fmu/export/source/actuator.cpp).

// Tensions of all cables.
template <class T> struct ChainTensions {
    const T* chains;               // (m, 33)
    const T* command;              // (m), N: static tension of the winch
    const T* length;               // (m), m, between winch and platform
    const T* rate;                 // (m), m/s, rate of the length
    const T* length_acceleration;  // (m), m/s^2, rate of that rate for a platform without acceleration
    WinchStates<T> states;
    T* tension;  // (m), N, without the effect of the winches' inertia at an accelerating platform
    T* mass;     // (m), kg, that inertia as a mass along the cable
    int64_t m;
};

template <class T> inline int chain_tensions(ChainTensions<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        WinchTension<T> own;
        if (row.stretches()) {
            const SpanMotion<T> motion = cables.states.span(i, row, cables.length[i], cables.rate[i]);
            own = {pull(row.span_kind(), motion, row.lowest()), 0.0};
        } else {
            own = row.held(cables.states.own(i, false), cables.command[i], cables.length[i], cables.rate[i],
                           cables.length_acceleration[i]);
        }
        cables.tension[i] = own.tension;
        cables.mass[i] = own.mass;
    }
    return 0;
}

// Time derivatives of winches with elastic cables.
template <class T> struct ChainSlopes {
    const T* chains;   // (m, 33)
    const T* command;  // (m), N
    const T* tension;  // (m), N
    const T* length;   // (m), m
    const T* rate;     // (m), m/s
    WinchStates<T> states;
    WinchStates<T> slopes;
    int64_t m;
};

template <class T> inline int chain_slopes(ChainSlopes<T>& cables) {
    const WinchStates<T> states = cables.states, slopes = cables.slopes;
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        if (!row.stretches()) continue;
        const T speed = states.speed(i), unwound = states.unwound(i), load = row.load(cables.tension[i], speed);
        T present[ChainRow<T>::NUMBERS];
        const T *numbers = row.winch(unwound, present), *own = states.own(i, true);
        const WinchMotion<T> motion = {numbers, own, cables.command[i], load, unwound, speed, row.transmission()};
        slopes.unwound(i) = -row.per_turn(unwound) * speed;
        slopes.speed(i) = drum_acceleration(row.winch_kind(), motion);
        own_slopes(row.winch_kind(), motion, slopes.own(i, true), states.own_count(i, row));
        span_slopes(row.span_kind(), states.span(i, row, cables.length[i], cables.rate[i]), row.lowest(),
                    slopes.of_span(i, row));
    }
    return 0;
}

// Start of winches with elastic cables: each tension is its command, with constant stretch.
template <class T> struct ChainStart {
    const T* chains;   // (m, 33)
    const T* command;  // (m), N
    const T* length;   // (m), m
    const T* rate;     // (m), m/s
    WinchStates<T> states;
    int64_t m;
};

template <class T> inline int chain_start(ChainStart<T>& cables) {
    for (int64_t i = 0; i < cables.m; i++) {
        const ChainRow<T> row = chain_row(cables.chains, i);
        if (!row.stretches()) continue;
        const T command = cables.command[i];
        const T kind = row.span_kind(), length = cables.length[i], unwound = rest(kind, row.span(), length, command);
        const T speed = -cables.rate[i] / row.per_turn(unwound), load = row.load(command, speed);
        T present[ChainRow<T>::NUMBERS], *own = cables.states.own(i, true);
        cables.states.unwound(i) = unwound;
        cables.states.speed(i) = speed;
        span_start(kind, row.span(), length, unwound, row.lowest(), cables.states.of_span(i, row));
        own_start(row.winch_kind(),
                  {row.winch(unwound, present), own, command, load, unwound, speed, row.transmission()}, own,
                  cables.states.own_count(i, row));
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
