// Elementary functions by arithmetic alone, also in lanes: the C library has them for one number at a time.
// SPDX-License-Identifier: Apache-2.0
//
// Polynomials are Taylor's, beyond whose last term less than the round-off remains; pairs of terms are summed first
// (Estrin), which shortens the chain of operations. Same bits on every platform.
#pragma once

#include <string.h>

#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

// Return 2^k for a whole number k from -1022 to 1023.
CDPR_INLINE double power_of_two(double k) {
    const int64_t word = (static_cast<int64_t>(k) + 1023) << 52;
    double power;
    memcpy(&power, &word, sizeof power);
    return power;
}

// Added to a number below 2^51 and taken away again, it leaves the nearest whole number.
constexpr double TO_WHOLE = 6755399441055744.0;  // 1.5 * 2^52

#ifdef CDPR_LANES
CDPR_INLINE Lanes power_of_two(const Lanes& k) {
    const auto power = [](const Part& x, const Part&) -> Part {
        const Part rounding = TO_WHOLE - Part{};
        return (Part)(((PartMask)(x + rounding) - (PartMask)rounding + 1023) << 52);
    };
    return each_part(power, k, k);
}
#endif

// Return e^x with an error below one unit in the last place, for |x| up to 708; beyond, e^708 or e^-708.
template <class T> CDPR_INLINE T exponent_of(T x) {
    constexpr double PER_BINADE = 1.4426950408889634, HIGH = 6.93147180369123816490e-01,
                     LOW = 1.90821492927058770002e-10;
    const T bounded = larger(smaller(x, T(708.0)), T(-708.0));
    const T k = (bounded * PER_BINADE + TO_WHOLE) - TO_WHOLE;
    const T r = (bounded - k * HIGH) - k * LOW;  // at most ln(2) / 2; HIGH has 33 bits: its multiples are exact
    const T r2 = r * r, r4 = r2 * r2;
    const T first = (1.0 / 2.0 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0));
    const T second = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0));
    const T third = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0));
    return power_of_two(k) * (1.0 + (r + r2 * (first + r4 * (second + r4 * third))));
}

// Return tanh x to an absolute error of the round-off of 1; odd.
template <class T> CDPR_INLINE T saturation(T x) {
    const T size = 1.0 - 2.0 / (exponent_of(2.0 * absolute(x)) + 1.0);
    return select(x < T(0.0), -size, size);
}

// Return sin x for x from 0 to pi to an absolute error of the round-off of 1.
template <class T> CDPR_INLINE T sine_of_half_turn(T x) {
    const T u = x - 1.5707963267948966, z = u * u, z2 = z * z, z4 = z2 * z2;  // sin x = cos u
    const T first = (1.0 - z * (1.0 / 2.0)) + z2 * (1.0 / 24.0 - z * (1.0 / 720.0));
    const T second = (1.0 / 40320.0 - z * (1.0 / 3628800.0)) + z2 * (1.0 / 479001600.0 - z * (1.0 / 87178291200.0));
    const T third = (1.0 / 20922789888000.0 - z * (1.0 / 6402373705728000.0)) +
                    z2 * (1.0 / 2432902008176640000.0 - z * (1.0 / 1.1240007277776077e21));
    return first + z4 * (second + z4 * third);
}

}  // namespace cdpr::CDPR_TARGET
