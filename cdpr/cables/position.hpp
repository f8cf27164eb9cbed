// Winch that holds the commanded unwound length. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

// The drum stands at the command, m.
struct Position {
    template <class T> static CDPR_INLINE void prescribe(WinchMotion<T> motion, T& unwound, T& speed) {
        unwound = motion.command;
        speed = 0.0;
    }
};

}  // namespace cdpr::CDPR_TARGET
