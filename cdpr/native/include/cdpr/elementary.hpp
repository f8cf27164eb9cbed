// Elementary functions from sums, products and one quotient. SPDX-License-Identifier: Apache-2.0
//
// The C library takes one number at a time; these take lanes, and give the same bits on every platform. Polynomials are
// minimax fits (Remez) on the reduced ranges, in the order of Estrin.
#pragma once

#include <string.h>

#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

namespace elementary {

// n + SHIFT has the whole number n in its lowest bits, for |n| < 2^51.
constexpr double SHIFT = 6755399441055744.0;  // 1.5 * 2^52
constexpr int64_t BIAS = 1023, MANTISSA = 52;

// Return 2^n, |n| <= 1022, of n + SHIFT.
CDPR_INLINE double power_of_two(double shifted) {
    uint64_t bits = 0;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + BIAS) << MANTISSA;
    double found = 0.0;
    memcpy(&found, &bits, sizeof found);
    return found;
}

#ifdef CDPR_LANES
CDPR_INLINE Lanes power_of_two(const Lanes& shifted) {
    return each_part([](const Part& x, const Part&) -> Part { return (Part)(((PartMask)x + BIAS) << MANTISSA); },
                     shifted, shifted);
}
#endif

// c[0] + c[1] x + ... + c[9] x^9.
template <class T> CDPR_INLINE T polynomial(const double (&c)[10], T x) {
    const T x2 = x * x, x4 = x2 * x2;
    const T low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2;
    const T middle = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2;
    return (low + middle * x4) + (c[8] + c[9] * x) * (x4 * x4);
}

// exp(x) = power * (1 + more), with `power` a power of two and |more| < 0.42.
template <class T> struct Exponential {
    T power, more;
};

// |x| <= 700. The polynomial is that of (exp(r) - 1 - r) / r^2 on |r| <= log(2) / 2; its error is below 4e-18 exp(r).
template <class T> CDPR_INLINE Exponential<T> exponential_parts(T x) {
    constexpr double PER_LOG = 1.4426950408889634;  // 1 / log(2)
    constexpr double LOG_HIGH = 0.6931471803691238,
                     LOG_LOW = 1.9082149292705877e-10;  // log(2); 21 zero bits after HIGH
    constexpr double C[10] = {0.5000000000000012,     0.166666666666667,     0.04166666666651607,
                              0.00833333333330729,    0.0013888888946871224, 0.00019841269917225457,
                              2.4801490074111658e-05, 2.755721642294146e-06, 2.7631237994406954e-07,
                              2.5117827212453037e-08};
    const T shifted = PER_LOG * x + SHIFT, n = shifted - SHIFT;
    const T r = (x - LOG_HIGH * n) - LOG_LOW * n;
    return {power_of_two(shifted), r + (r * r) * polynomial(C, r)};
}

// |x| <= 700.
template <class T> CDPR_INLINE T exponential(T x) {
    const Exponential<T> found = exponential_parts(x);
    return found.power + found.power * found.more;
}

template <class T> CDPR_INLINE T hyperbolic_tangent(T x) {
    constexpr double ONE = 20.0;  // from here it rounds to 1
    const Exponential<T> twice = exponential_parts(2.0 * smaller(absolute(x), T(ONE)));
    const T grown = (twice.power - 1.0) + twice.power * twice.more, size = grown / (grown + 2.0);
    return select(x < T(0.0), -size, size);
}

// Return the angle, rad, of a unit vector, from 0 to three quarters of a turn; 0 in the last quarter. The polynomial is
// that of (asin(x) - x) / x^3 in x^2, for |x| up to the sine of an eighth of pi; its error is below 6e-18 x.
template <class T> CDPR_INLINE T angle_of_turn(T sine, T cosine) {
    constexpr double TANGENT = 0.41421356237309503, ROOT = 0.7071067811865476;  // of pi / 8; sqrt(1 / 2)
    constexpr double HALF = 1.5707963267948966, FULL = 3.141592653589793, MOST = 4.71238898038469, EIGHTH = HALF / 2.0;
    constexpr double C[10] = {0.16666666666666105,  0.07500000000185741,  0.04464285693109738,  0.030381956354130574,
                              0.0223717757214623,   0.017360358022653895, 0.013869436130545872, 0.012309553989657794,
                              0.006127904181515423, 0.01759041592122096};
    // The angle is that of the nearest axis, `about`, and a remainder of up to an eighth of a turn; of this, `small` is
    // the sine and `large` the cosine.
    const Truth<T> steep = absolute(sine) > absolute(cosine), back = cosine < T(0.0), below = sine < T(0.0);
    const T large = absolute(select(steep, sine, cosine)), along = select(steep, -cosine, sine);
    const T small = select(select(steep, sine, cosine) < T(0.0), -along, along), size = absolute(small);
    const T about = select(steep, select(below, T(MOST), T(HALF)), select(back, T(FULL), T(0.0)));
    const Truth<T> far = size > TANGENT * large;
    const T x = select(far, ROOT * (size - large), size), u = x * x;
    const T rest = select(far, T(EIGHTH), T(0.0)) + (x + (x * u) * polynomial(C, u));
    const T angle = about + select(small < T(0.0), -rest, rest);
    return select(below & !back, T(0.0), angle);
}

}  // namespace elementary

}  // namespace cdpr::CDPR_TARGET
