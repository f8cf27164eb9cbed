// Motor that holds the commanded tension. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

struct Direct {
    template <class T> static CDPR_INLINE WinchTension<T> held(const T*, T command, T, T) { return {command, 0.0}; }
    template <class T> static CDPR_INLINE T drum_acceleration(const T*, T, T, T) { return 0.0; }
};

}  // namespace cdpr::CDPR_TARGET
