// Tables of cable parts by kind. SPDX-License-Identifier: Apache-2.0
//
// A kind is a number in a row of a table, the same in all lanes. It is the position of the part in `cdpr.cables`, whose
// tests compare both. An unknown kind, or a row with too few numbers for its kind, gives NaN, which the checks detect.
#pragma once

#include <cdpr/cables/bent_cable.hpp>
#include <cdpr/cables/catenary/catenary.hpp>
#include <cdpr/cables/direct/direct.hpp>
#include <cdpr/cables/drum/drum.hpp>
#include <cdpr/cables/elastic/elastic.hpp>
#include <cdpr/cables/pulley/pulley.hpp>
#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

enum ExitKind { POINT, PULLEY };
enum WinchKind { DIRECT, DRUM };
enum SpanKind { INEXTENSIBLE, ELASTIC, CATENARY };

template <class T> CDPR_INLINE bool is(T kind, int expected) { return first(kind) == expected; }

template <class T> CDPR_INLINE Vector<T> nowhere() { return {NOT_A_NUMBER, NOT_A_NUMBER, NOT_A_NUMBER}; }

// Return the exit point, m, world axes, for a cable to `tip`.
template <class T>
CDPR_INLINE Vector<T> exit_point(T kind, Vector<T> anchor, const T* numbers, int64_t count, Vector<T> tip) {
    if (is(kind, POINT)) return anchor;
    if (is(kind, PULLEY) && count >= Pulley::COUNT) return Pulley::leave(anchor, numbers, tip);
    return nowhere<T>();
}

// Return that point, and the length of cable on the exit, m.
template <class T>
CDPR_INLINE ExitResult<T> lead(T kind, Vector<T> anchor, const T* numbers, int64_t count, Vector<T> tip) {
    if (is(kind, POINT)) return {anchor, 0.0};
    if (is(kind, PULLEY) && count >= Pulley::COUNT) return Pulley::lead(anchor, numbers, tip);
    return {nowhere<T>(), NOT_A_NUMBER};
}

// Return the velocity of the exit point, m/s, while `tip` moves with V.
template <class T> CDPR_INLINE Vector<T> exit_velocity(T kind, Vector<T> anchor, const T* numbers, int64_t count,
                                                       Vector<T> tip, Vector<T> V) {
    if (is(kind, POINT)) return {0.0, 0.0, 0.0};
    if (is(kind, PULLEY) && count >= Pulley::COUNT) return Pulley::carry(anchor, numbers, tip, V);
    return nowhere<T>();
}

// Return tension, N, and mass, kg, of a winch whose cable does not stretch; `own` are the winch's own state numbers.
template <class T> CDPR_INLINE WinchTension<T> held(T kind, const T* numbers, [[maybe_unused]] const T* own, T command,
                                                    T rate, T length_acceleration) {
    if (is(kind, DIRECT)) return Direct::held(numbers, command, rate, length_acceleration);
    if (is(kind, DRUM)) return Drum::held(numbers, command, rate, length_acceleration);
    return {NOT_A_NUMBER, NOT_A_NUMBER};
}

// Return the acceleration of the winch's coordinate.
template <class T> CDPR_INLINE T drum_acceleration(T kind, const T* numbers, [[maybe_unused]] const T* own, T command,
                                                   T tension, T speed) {
    if (is(kind, DIRECT)) return Direct::drum_acceleration(numbers, command, tension, speed);
    if (is(kind, DRUM)) return Drum::drum_acceleration(numbers, command, tension, speed);
    return NOT_A_NUMBER;
}

// Write the `count` own state numbers of a winch at its start. None of ours has any.
template <class T>
CDPR_INLINE void own_start([[maybe_unused]] T kind, [[maybe_unused]] WinchMotion<T> motion, T* own, int64_t count) {
    for (int64_t j = 0; j < count; j++) own[j] = NOT_A_NUMBER;
}

// Write their time derivatives.
template <class T>
CDPR_INLINE void own_slopes([[maybe_unused]] T kind, [[maybe_unused]] WinchMotion<T> motion, T* slope, int64_t count) {
    for (int64_t j = 0; j < count; j++) slope[j] = NOT_A_NUMBER;
}

// Return the tension of an elastic span, N.
template <class T> CDPR_INLINE T pull(T kind, const T* numbers, T length, T unwound, T stretching, T lowest) {
    if (is(kind, ELASTIC)) return Elastic::pull(numbers, length, unwound, stretching, lowest);
    return NOT_A_NUMBER;
}

// Return the unwound length, m, of an elastic span with this tension, N.
template <class T> CDPR_INLINE T rest(T kind, const T* numbers, T length, T tension) {
    if (is(kind, ELASTIC)) return Elastic::rest(numbers, length, tension);
    return NOT_A_NUMBER;
}

// Return whether the force of an elastic span may have another direction than its chord. Such a span has `bent_pull`
// and `bent_rest` in place of `pull` and `rest`.
template <class T> CDPR_INLINE bool bends(T kind) { return is(kind, CATENARY); }

// Return force and tension, N, of a bent span with this unwound length, m, and rate of stretch, m/s; `lowest` as for
// `pull`.
template <class T> CDPR_INLINE BentCable<T> bent_pull(T kind, BentSpan<T> span, T unwound, T stretching, T lowest) {
    if (is(kind, CATENARY)) return Catenary::pull(span, unwound, stretching, lowest);
    return {nowhere<T>(), NOT_A_NUMBER};
}

// Return the unwound length, m, of a bent span with this tension, N, at its winch.
template <class T> CDPR_INLINE T bent_rest(T kind, BentSpan<T> span, T tension) {
    if (is(kind, CATENARY)) return Catenary::rest(span, tension);
    return NOT_A_NUMBER;
}

}  // namespace cdpr::CDPR_TARGET
