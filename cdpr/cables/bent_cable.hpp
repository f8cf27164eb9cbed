// Spans with a force on the platform that is not along the chord. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct BentSpan {
    const T* numbers;          // of the part
    Vector<T> chord;           // m, from the platform to the exit, world axes
    T wrapped_length;          // m, of cable on the exit
    Vector<T> gravity;         // m/s^2
    Vector<T> exit_to_anchor;  // m, over the exit
};

template <class T> struct BentCable {
    Vector<T> force;  // N, on the platform, world axes
    T tension;        // N, at the winch
};

// Rates of the ends and of the unwound length of a bent span.
struct BentMotion {
    Vector<double> chord;           // m/s
    double wrapped_length;          // m/s
    Vector<double> exit_to_anchor;  // m/s
    double unwound;                 // m/s
};

}  // namespace cdpr::CDPR_TARGET
