// Cable that stretches along its chord. SPDX-License-Identifier: Apache-2.0
//
// T = E A (l - l0) / l0 + d (l' - l0'); see the docstring of this package. `numbers`: E A, N; damping d, N s/m.
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct Elastic {
    static constexpr int STIFFNESS = 0, DAMPING = 1;

    // Return the tension, N, of a cable with this length, unwound length, m, and rate of stretch, m/s; at least
    // `lowest`: 0, or minus infinity for a leg that pushes.
    template <class T> static CDPR_INLINE T pull(const T* numbers, T length, T unwound, T stretching, T lowest) {
        const T stretch = length - unwound;
        const T tension = numbers[STIFFNESS] * stretch / unwound + numbers[DAMPING] * stretching;
        const Truth<T> slack = (stretch <= T(0.0)) & (lowest == T(0.0));
        return select(slack, T(0.0), select(tension < lowest, lowest, tension));
    }

    // Return the unwound length, m, of a cable at rest with this tension, N.
    template <class T> static CDPR_INLINE T rest(const T* numbers, T length, T tension) {
        return length / (1.0 + tension / numbers[STIFFNESS]);
    }
};

}  // namespace cdpr::CDPR_TARGET
