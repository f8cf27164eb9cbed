// Drive that pays out exactly at the commanded rate. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

struct IdealDrive {
    static constexpr int RADIUS = 0;

    // Return the speed of the drum, rad/s, at which the unwound length changes by the command, m/s.
    template <class T> static CDPR_INLINE T speed(const T* numbers, T command) { return -command / numbers[RADIUS]; }
};

}  // namespace cdpr::CDPR_TARGET
