// Numbers of a row of a matrix side by side. SPDX-License-Identifier: Apache-2.0
//
// A strip holds as many doubles as a register, or one number in lanes. Operations act on each number, so the bits do
// not depend on the registers.
#pragma once

#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

// Unroll the next loop, of a fixed number of repetitions: g++ -O2 would keep the strips in memory for a loop.
#if defined(__clang__)
#define CDPR_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__)
#define CDPR_UNROLL _Pragma("GCC unroll 12")
#else
#define CDPR_UNROLL
#endif

// Strip of numbers of type T; COLUMNS: their number, a divisor of 12.
template <class T> struct Strip {
    typedef T type;
    static constexpr int COLUMNS = 1;
};

// Read consecutive numbers of a row.
template <class T> CDPR_INLINE typename Strip<T>::type strip(const T* row) { return *row; }

// Read the numbers of a column in consecutive rows, which begin `stride` numbers apart.
template <class T> CDPR_INLINE typename Strip<T>::type strip_of_column(const T* column, int) { return *column; }

#ifdef CDPR_LANES

template <> struct Strip<double> {
    static constexpr int COLUMNS = PART < 4 ? 2 : 4;
    typedef double type __attribute__((vector_size(8 * COLUMNS), aligned(8), may_alias));
};
typedef Strip<double>::type DoubleStrip;

template <> CDPR_INLINE DoubleStrip strip<double>(const double* row) {
    return *reinterpret_cast<const DoubleStrip*>(row);
}
template <> CDPR_INLINE DoubleStrip strip_of_column<double>(const double* column, int stride) {
    DoubleStrip found;
    CDPR_UNROLL
    for (int i = 0; i < Strip<double>::COLUMNS; i++) found[i] = column[i * stride];
    return found;
}
CDPR_INLINE void store(const DoubleStrip& numbers, double* row) { *reinterpret_cast<DoubleStrip*>(row) = numbers; }
CDPR_INLINE DoubleStrip select(bool condition, const DoubleStrip& a, const DoubleStrip& b) { return condition ? a : b; }

CDPR_INLINE void store(const Lanes& number, Lanes* row) { *row = number; }

#else

CDPR_INLINE void store(double number, double* row) { *row = number; }

#endif

}  // namespace cdpr::CDPR_TARGET
