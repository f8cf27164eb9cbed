// Winch that pays out at the commanded rate. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

// The unwound length changes by the command, m/s.
struct Velocity {
    static constexpr int RADIUS = 0;

    template <class T> static CDPR_INLINE void prescribe(WinchMotion<T> motion, T&, T& speed) {
        speed = -motion.command / motion.numbers[RADIUS];
    }
};

}  // namespace cdpr::CDPR_TARGET
