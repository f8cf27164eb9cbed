// Operations of the loop that belong to no part. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/status.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

// An engine's clock is a sum of steps: after 1e8 of them it may be off by this share. A reset is off by much more.
constexpr double CLOCK_TOLERANCE = 1e-6;

template <class T> struct Copy {
    const T* source;  // (n)
    T* target;        // (n)
    int64_t n;
    static constexpr Field fields[] = {in<T>("source", "n"), out<T>("target", "n"), size("n")};
};

template <class T> inline int copy(Copy<T>& arrays) {
    for (int64_t i = 0; i < arrays.n; i++) arrays.target[i] = arrays.source[i];
    return 0;
}

template <class T> struct Stamp {
    T* row;  // (width), of the log; its first number is the time, s
    int64_t width;
    static constexpr Field fields[] = {both<T>("row", "width >= 1"), size("width")};
};

// Write the time, s, of a sample into its row.
template <class T> inline int stamp(Stamp<T>& sample, double time) {
    sample.row[0] = time;
    return 0;
}

template <class T> struct Values {
    const T* values;  // (n)
    int64_t n;
    static constexpr Field fields[] = {in<T>("values", "n"), size("n")};
};

// Return 1 if a value is infinite or NaN; of lanes, the bits of those.
template <class T> inline int not_finite(Values<T>& array) {
    const T zero = sum(T(0.0), 0, array.n, [&](int64_t i) { return 0.0 * array.values[i]; });
    return code(select(zero == T(0.0), T(0.0), T(1.0)));
}

struct Clock {
    const double* clock;  // (1), of an engine, s
    static constexpr Field fields[] = {in("clock", "1")};
};

// Return 1 if an engine's clock differs from the time, s, of the sample, or is NaN.
inline int clock_differs(Clock& engine, double time) {
    return !(absolute(engine.clock[0] - time) <= CLOCK_TOLERANCE * time);
}

// Wrench and its status where there is no power: nothing is required of the cables.
template <class T> struct PowerOff {
    T* wrench;  // (6), N and N m
    T* status;  // (n), status and number of cables at a limit
    int64_t n;
    static constexpr Field fields[] = {out<T>("wrench", "6"), out<T>("status", "n"), size("n")};
};

template <class T> inline int power_off(PowerOff<T>& sample) {
    for (int i = 0; i < 6; i++) sample.wrench[i] = 0.0;
    for (int64_t i = 0; i < sample.n; i++) sample.status[i] = 0.0;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
