// Eight doubles in a register, or in several narrower ones. SPDX-License-Identifier: Apache-2.0
//
// A number beside lanes means eight equal ones. Arrays of lanes have the lane as their last axis, length 8, and need
// only the alignment of doubles.
#pragma once

#include <cdpr/number.hpp>

#ifdef CDPR_LANES
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wpsabi"  // about the passing of lanes: all these functions are inlined
#endif

namespace cdpr::CDPR_TARGET {

constexpr int WIDTH = 8;

// Numbers in a register: g++ computes conditions of wider vectors one number at a time.
#if defined(__AVX512F__)
constexpr int PART = 8;
#elif defined(__AVX__)
constexpr int PART = 4;
#else
constexpr int PART = 2;
#endif
constexpr int PARTS = WIDTH / PART;
// Loops over the parts are unrolled: with -O2 g++ would keep them, and numbers in memory, which takes 7 times as long
// in registers of two.

typedef double Part __attribute__((vector_size(8 * PART), aligned(8), may_alias));
typedef int64_t PartMask __attribute__((vector_size(8 * PART), aligned(8), may_alias));  // -1 where true

struct Mask {
    PartMask part[PARTS];

    Mask() = default;
    CDPR_INLINE Mask(bool same) {
#pragma GCC unroll 4
        for (int i = 0; i < PARTS; i++) part[i] = PartMask{} - int64_t(same);
    }
    CDPR_INLINE Mask(const Mask& other) { *this = other; }
    CDPR_INLINE Mask& operator=(const Mask& other) {  // as for Lanes
#pragma GCC unroll 4
        for (int i = 0; i < PARTS; i++) part[i] = other.part[i];
        return *this;
    }

    CDPR_INLINE bool get(int lane) const { return part[lane / PART][lane % PART] != 0; }
};

struct Lanes {
    Part part[PARTS];

    Lanes() = default;
    // Register by register: g++ would copy 16 bytes at a time, and loading a register would wait for these.
    CDPR_INLINE Lanes(const Lanes& other) {
#pragma GCC unroll 4
        for (int i = 0; i < PARTS; i++) part[i] = other.part[i];
    }
    CDPR_INLINE Lanes& operator=(const Lanes& other) {
#pragma GCC unroll 4
        for (int i = 0; i < PARTS; i++) part[i] = other.part[i];
        return *this;
    }
    CDPR_INLINE Lanes(double same) {
#pragma GCC unroll 4
        for (int i = 0; i < PARTS; i++) part[i] = same - Part{};  // keeps the sign of zero
    }

    CDPR_INLINE double get(int lane) const { return part[lane / PART][lane % PART]; }
    CDPR_INLINE void set(int lane, double number) { part[lane / PART][lane % PART] = number; }
};

// Read eight numbers of an array at a distance of `stride`.
CDPR_INLINE Lanes gather(const double* first, int64_t stride) {
    Lanes found;
#pragma GCC unroll 4
    for (int i = 0; i < PARTS; i++) {
        Part part;
        for (int k = 0; k < PART; k++) part[k] = first[(PART * i + k) * stride];
        found.part[i] = part;
    }
    return found;
}

// Write eight consecutive numbers of an array.
CDPR_INLINE void scatter(const Lanes& lanes, double* array) {
#pragma GCC unroll 4
    for (int i = 0; i < PARTS; i++) *reinterpret_cast<Part*>(array + PART * i) = lanes.part[i];
}

template <class Function> CDPR_INLINE Lanes each_part(Function function, const Lanes& a, const Lanes& b) {
    Lanes found;
#pragma GCC unroll 4
    for (int i = 0; i < PARTS; i++) found.part[i] = function(a.part[i], b.part[i]);
    return found;
}
template <class Function> CDPR_INLINE Mask compare(Function function, const Lanes& a, const Lanes& b) {
    Mask found;
#pragma GCC unroll 4
    for (int i = 0; i < PARTS; i++) found.part[i] = function(a.part[i], b.part[i]);
    return found;
}
template <class Function> CDPR_INLINE Mask combine(Function function, const Mask& a, const Mask& b) {
    Mask found;
#pragma GCC unroll 4
    for (int i = 0; i < PARTS; i++) found.part[i] = function(a.part[i], b.part[i]);
    return found;
}

CDPR_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
    return each_part([](const Part& x, const Part& y) -> Part { return x + y; }, a, b);
}
CDPR_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
    return each_part([](const Part& x, const Part& y) -> Part { return x - y; }, a, b);
}
CDPR_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
    return each_part([](const Part& x, const Part& y) -> Part { return x * y; }, a, b);
}
CDPR_INLINE Lanes operator/(const Lanes& a, const Lanes& b) {
    return each_part([](const Part& x, const Part& y) -> Part { return x / y; }, a, b);
}
CDPR_INLINE Lanes operator-(const Lanes& a) {
    return each_part([](const Part& x, const Part&) -> Part { return -x; }, a, a);
}
CDPR_INLINE Lanes& operator+=(Lanes& a, const Lanes& b) { return a = a + b; }
CDPR_INLINE Lanes& operator-=(Lanes& a, const Lanes& b) { return a = a - b; }
CDPR_INLINE Lanes& operator*=(Lanes& a, const Lanes& b) { return a = a * b; }

CDPR_INLINE Mask operator<(const Lanes& a, const Lanes& b) {
    return compare([](const Part& x, const Part& y) -> PartMask { return x < y; }, a, b);
}
CDPR_INLINE Mask operator<=(const Lanes& a, const Lanes& b) {
    return compare([](const Part& x, const Part& y) -> PartMask { return x <= y; }, a, b);
}
CDPR_INLINE Mask operator>(const Lanes& a, const Lanes& b) { return b < a; }
CDPR_INLINE Mask operator>=(const Lanes& a, const Lanes& b) { return b <= a; }
CDPR_INLINE Mask operator==(const Lanes& a, const Lanes& b) {
    return compare([](const Part& x, const Part& y) -> PartMask { return x == y; }, a, b);
}
CDPR_INLINE Mask operator!=(const Lanes& a, const Lanes& b) {
    return compare([](const Part& x, const Part& y) -> PartMask { return x != y; }, a, b);
}

CDPR_INLINE Mask operator&(const Mask& a, const Mask& b) {
    return combine([](const PartMask& x, const PartMask& y) -> PartMask { return x & y; }, a, b);
}
CDPR_INLINE Mask operator|(const Mask& a, const Mask& b) {
    return combine([](const PartMask& x, const PartMask& y) -> PartMask { return x | y; }, a, b);
}
CDPR_INLINE Mask operator!(const Mask& a) {
    return combine([](const PartMask& x, const PartMask&) -> PartMask { return ~x; }, a, a);
}

// One bit per lane, 1 for the first.
CDPR_INLINE int bits(const Mask& mask) {
    int found = 0;
    for (int lane = 0; lane < WIDTH; lane++) found |= int(mask.get(lane)) << lane;
    return found;
}

CDPR_INLINE bool any(const Mask& mask) {
    PartMask found = mask.part[0];
    for (int i = 1; i < PARTS; i++) found |= mask.part[i];
    int64_t one = 0;
    for (int i = 0; i < PART; i++) one |= found[i];
    return one != 0;
}
CDPR_INLINE bool all(const Mask& mask) { return !any(!mask); }

CDPR_INLINE Part select(const PartMask& mask, const Part& a, const Part& b) {
    if constexpr (PART > 2) return mask ? a : b;
    return (Part)((mask & (PartMask)a) | (~mask & (PartMask)b));  // g++ 12 fails on conditions of two numbers
}
CDPR_INLINE Lanes select(const Mask& mask, const Lanes& a, const Lanes& b) {
    Lanes found;
#pragma GCC unroll 4
    for (int i = 0; i < PARTS; i++) found.part[i] = select(mask.part[i], a.part[i], b.part[i]);
    return found;
}
CDPR_INLINE Lanes select(bool condition, const Lanes& a, const Lanes& b) { return condition ? a : b; }
CDPR_INLINE double first(const Lanes& lanes) { return lanes.get(0); }

// Apply a function of doubles to each lane.
template <class Function> CDPR_INLINE Lanes each(Function function, const Lanes& a, const Lanes& b) {
    const auto part = [&](const Part& x, const Part& y) -> Part {
        Part found = x;
        for (int i = 0; i < PART; i++) found[i] = function(x[i], y[i]);
        return found;
    };
    return each_part(part, a, b);
}

CDPR_INLINE Lanes absolute(const Lanes& a) {
    return each_part([](const Part& x, const Part&) -> Part { return (Part)((PartMask)x & INT64_MAX); }, a, a);
}
CDPR_INLINE Lanes square_root(const Lanes& a) {
    return each([](double x, double) { return square_root(x); }, a, a);
}
CDPR_INLINE Lanes sine(const Lanes& a) {
    return each([](double x, double) { return sine(x); }, a, a);
}
CDPR_INLINE Lanes cosine(const Lanes& a) {
    return each([](double x, double) { return cosine(x); }, a, a);
}
CDPR_INLINE Lanes hyperbolic_tangent(const Lanes& a) {
    return each([](double x, double) { return hyperbolic_tangent(x); }, a, a);
}
CDPR_INLINE Lanes exponential(const Lanes& a) {
    return each([](double x, double) { return exponential(x); }, a, a);
}
CDPR_INLINE Lanes hypotenuse(const Lanes& a, const Lanes& b) {
    return each([](double x, double y) { return hypotenuse(x, y); }, a, b);
}
CDPR_INLINE Lanes truncated(const Lanes& a) {
    return each([](double x, double) { return truncated(x); }, a, a);
}
CDPR_INLINE Lanes remainder_of(const Lanes& count, int64_t divisor) {
    return each([=](double x, double) { return remainder_of(x, divisor); }, count, count);
}
CDPR_INLINE Lanes angle_of(const Lanes& sine, const Lanes& cosine) {
    return each([](double y, double x) { return angle_of(y, x); }, sine, cosine);
}

}  // namespace cdpr::CDPR_TARGET

#endif
