// Number types of the kernels: double, and Lanes, eight doubles side by side. SPDX-License-Identifier: Apache-2.0
//
// A kernel is a template over the number type T. Instead of branching on a number it selects: `select(condition, a, b)`
// selects per lane, `if (any(condition))` branches for all eight, `whole` reads an index, which is the same in all.
// Each lane goes through the same operations in the same order as a double, so the bits are the same.
#pragma once

#include <math.h>
#include <stdint.h>

#include <cdpr/target.hpp>

namespace cdpr::CDPR_TARGET {

constexpr double INFINITE = HUGE_VAL;
constexpr double NOT_A_NUMBER = NAN;

CDPR_INLINE bool any(bool condition) { return condition; }
CDPR_INLINE bool all(bool condition) { return condition; }
CDPR_INLINE double select(bool condition, double a, double b) { return condition ? a : b; }
CDPR_INLINE double first(double number) { return number; }
CDPR_INLINE double absolute(double number) { return ::fabs(number); }
CDPR_INLINE double square_root(double number) { return ::sqrt(number); }
CDPR_INLINE double copy_sign(double size, double sign) { return ::copysign(size, sign); }
CDPR_INLINE double sine(double angle) { return ::sin(angle); }
CDPR_INLINE double cosine(double angle) { return ::cos(angle); }
CDPR_INLINE double hyperbolic_tangent(double number) { return ::tanh(number); }
CDPR_INLINE double exponential(double number) { return ::exp(number); }
CDPR_INLINE double hypotenuse(double a, double b) { return ::hypot(a, b); }
CDPR_INLINE double truncated(double number) { return double(int64_t(number)); }  // below 2^63 in size
CDPR_INLINE double remainder_of(double count, int64_t divisor) { return double(int64_t(count) % divisor); }
CDPR_INLINE double angle_of(double sine, double cosine) { return ::atan2(sine, cosine); }

template <class T> using Truth = decltype(T() < T());  // bool, or Mask for Lanes

// Like Python's max and min: the first, unless the second exceeds it; comparisons with NaN are false.
template <class T> CDPR_INLINE T larger(T a, T b) { return select(b > a, b, a); }
template <class T> CDPR_INLINE T smaller(T a, T b) { return select(b < a, b, a); }

template <class T> CDPR_INLINE Truth<T> finite(T number) { return absolute(number) < T(INFINITE); }

CDPR_INLINE bool all_finite(const double* numbers, int64_t count) {
    for (int64_t i = 0; i < count; i++)
        if (!finite(numbers[i])) return false;
    return true;
}

// Index stored as a number, the same in all lanes.
template <class T> CDPR_INLINE int64_t whole(T number) { return static_cast<int64_t>(first(number)); }

}  // namespace cdpr::CDPR_TARGET
