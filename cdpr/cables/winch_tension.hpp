// Tension and motion of a winch. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int MOST_STATES = 16;  // of a winch, as in `cdpr.cables.chain`

// Result of a winch whose cable does not stretch.
template <class T> struct WinchTension {
    T tension;  // N, without the effect of the winch's inertia at an accelerating platform
    T mass;     // kg, that inertia as a mass along the cable
};

// State of a winch with state numbers of its own.
template <class T> struct WinchMotion {
    const T* numbers;  // of the part; the first is the present cable per unit of its coordinate
    const T* own;      // its own state numbers
    T command;
    T tension;              // N, of its cable, with the loss of the transmission
    T unwound;              // m, unstretched length; of a cable that does not stretch, the length
    T speed;                // of its coordinate, such as rad/s, positive when winding in
    const T* transmission;  // transmission.hpp
};

}  // namespace cdpr::CDPR_TARGET
