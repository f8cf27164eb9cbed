// Eight doubles in a register, or in several where registers are narrower. SPDX-License-Identifier: Apache-2.0
//
// A number beside lanes stands for eight of the same. Arrays of lanes have the lane as their last axis, length 8, and
// need no more alignment than doubles.
#pragma once

#include <cdpr/number.hpp>

#ifdef __GNUC__
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wpsabi"  // on how lanes are passed: none of these functions is called, all are inline
#endif

namespace cdpr {
inline namespace CDPR_TARGET {

constexpr int WIDTH = 8;

typedef double Eight __attribute__((vector_size(64), aligned(8), may_alias));
typedef decltype(Eight() < Eight()) EightAnswers; // -1 where true

struct Mask {
    EightAnswers value;

    Mask() = default;
    CDPR_INLINE Mask(const EightAnswers& given) : value(given) {}
    CDPR_INLINE Mask(bool same) : value(EightAnswers{} - same) {}
};

struct Lanes {
    Eight value;

    Lanes() = default;
    CDPR_INLINE Lanes(const Eight& given) : value(given) {}
    CDPR_INLINE Lanes(double same) : value{same, same, same, same, same, same, same, same} {}

    CDPR_INLINE Lanes& operator+=(Lanes other) { return *this = Lanes(value + other.value); }
    CDPR_INLINE Lanes& operator-=(Lanes other) { return *this = Lanes(value - other.value); }
    CDPR_INLINE Lanes& operator*=(Lanes other) { return *this = Lanes(value * other.value); }
    CDPR_INLINE Lanes& operator/=(Lanes other) { return *this = Lanes(value / other.value); }
};

CDPR_INLINE Lanes operator-(Lanes a) { return -a.value; }
CDPR_INLINE Lanes operator+(Lanes a, Lanes b) { return a.value + b.value; }
CDPR_INLINE Lanes operator-(Lanes a, Lanes b) { return a.value - b.value; }
CDPR_INLINE Lanes operator*(Lanes a, Lanes b) { return a.value * b.value; }
CDPR_INLINE Lanes operator/(Lanes a, Lanes b) { return a.value / b.value; }

CDPR_INLINE Mask operator<(Lanes a, Lanes b) { return a.value < b.value; }
CDPR_INLINE Mask operator<=(Lanes a, Lanes b) { return a.value <= b.value; }
CDPR_INLINE Mask operator>(Lanes a, Lanes b) { return a.value > b.value; }
CDPR_INLINE Mask operator>=(Lanes a, Lanes b) { return a.value >= b.value; }
CDPR_INLINE Mask operator==(Lanes a, Lanes b) { return a.value == b.value; }
CDPR_INLINE Mask operator!=(Lanes a, Lanes b) { return a.value != b.value; }

CDPR_INLINE Mask operator&(Mask a, Mask b) { return a.value & b.value; }
CDPR_INLINE Mask operator|(Mask a, Mask b) { return a.value | b.value; }
CDPR_INLINE Mask operator!(Mask a) { return ~a.value; }

// One bit per lane, 1 for the first.
CDPR_INLINE int bits(Mask mask) {
    int found = 0;
    for (int i = 0; i < WIDTH; i++) found |= (mask.value[i] != 0) << i;
    return found;
}

CDPR_INLINE bool any(Mask mask) { return bits(mask) != 0; }
CDPR_INLINE bool all(Mask mask) { return bits(mask) == (1 << WIDTH) - 1; }
CDPR_INLINE Lanes select(Mask mask, Lanes a, Lanes b) { return mask.value ? a.value : b.value; }
CDPR_INLINE Lanes select(bool condition, Lanes a, Lanes b) { return condition ? a : b; }
CDPR_INLINE double first(Lanes lanes) { return lanes.value[0]; }

// Apply a function of doubles to each lane.
template <class Function> CDPR_INLINE Lanes each(Function function, Lanes a) {
    Lanes found;
    for (int i = 0; i < WIDTH; i++) found.value[i] = function(a.value[i]);
    return found;
}

CDPR_INLINE Lanes absolute(Lanes a) {
    return each([](double number) { return absolute(number); }, a);
}
CDPR_INLINE Lanes square_root(Lanes a) {
    return each([](double number) { return square_root(number); }, a);
}
CDPR_INLINE Lanes sine(Lanes a) {
    return each([](double number) { return sine(number); }, a);
}
CDPR_INLINE Lanes cosine(Lanes a) {
    return each([](double number) { return cosine(number); }, a);
}
CDPR_INLINE Lanes hyperbolic_tangent(Lanes a) {
    return each([](double number) { return hyperbolic_tangent(number); }, a);
}
CDPR_INLINE Lanes angle_of(Lanes sine, Lanes cosine) {
    Lanes found;
    for (int i = 0; i < WIDTH; i++) found.value[i] = angle_of(sine.value[i], cosine.value[i]);
    return found;
}

}  // namespace CDPR_TARGET
}  // namespace cdpr

#endif
