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

}  // namespace cdpr::CDPR_TARGET
