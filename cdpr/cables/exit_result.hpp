// Result of an exit. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct ExitResult {
    Vector<T> point;             // m, world, where the cable leaves the frame
    T wrapped_length;            // m, length of cable on the exit
    T sine = 0.0, cosine = 1.0;  // of the angle of cable on the exit
};

}  // namespace cdpr::CDPR_TARGET
