// Result of a winch whose cable does not stretch. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct WinchTension {
    T tension;  // N, without the effect of the winch's inertia at an accelerating platform
    T mass;     // kg, that inertia as a mass along the cable
};

}  // namespace cdpr::CDPR_TARGET
