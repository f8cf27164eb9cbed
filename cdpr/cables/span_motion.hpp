// State and motion of a span that stretches along its chord. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int MOST_SPAN_STATES = 4;  // as in `cdpr.cables.chain`

template <class T> struct SpanMotion {
    const T* numbers;  // of the span
    const T* own;      // its state numbers
    T length;          // m
    T unwound;         // m, unstretched length
    T unwinding;       // m/s, its rate
    T stretching;      // m/s, rate of the length less that of the unwound length

    CDPR_INLINE T strain() const { return (length - unwound) / unwound; }
    CDPR_INLINE T strain_rate() const { return (stretching - strain() * unwinding) / unwound; }
};

}  // namespace cdpr::CDPR_TARGET
