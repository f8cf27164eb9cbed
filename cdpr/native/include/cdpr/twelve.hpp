// Twelve doubles side by side, such as a row of a covariance. SPDX-License-Identifier: Apache-2.0
//
// Operations act on each number, so the bits do not depend on the registers.
#pragma once

#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

#ifdef CDPR_LANES
constexpr int PIECE = PART < 4 ? 2 : 4;  // numbers in a register
typedef double RowPiece __attribute__((vector_size(8 * PIECE), aligned(8), may_alias));
#else
constexpr int PIECE = 1;
typedef double RowPiece;
#endif

// Unroll the next loop, of a fixed number of repetitions: g++ -O2 would keep the pieces in memory for a loop.
#if defined(__clang__)
#define CDPR_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__)
#define CDPR_UNROLL _Pragma("GCC unroll 12")
#else
#define CDPR_UNROLL
#endif

struct Twelve {
    static constexpr int PIECES = 12 / PIECE;

    RowPiece piece[PIECES];

    Twelve() = default;
    CDPR_INLINE Twelve(const Twelve& other) { *this = other; }
    CDPR_INLINE Twelve& operator=(const Twelve& other) {  // register by register, as for Lanes
        CDPR_UNROLL
        for (int i = 0; i < PIECES; i++) piece[i] = other.piece[i];
        return *this;
    }
};

template <class Function> CDPR_INLINE Twelve each_piece(Function function) {
    Twelve found;
    CDPR_UNROLL
    for (int i = 0; i < Twelve::PIECES; i++) found.piece[i] = function(i);
    return found;
}

// Read twelve numbers of an array.
CDPR_INLINE Twelve twelve(const double* array) {
    return each_piece([&](int i) -> RowPiece { return *reinterpret_cast<const RowPiece*>(array + PIECE * i); });
}

CDPR_INLINE void store(const Twelve& row, double* array) {
    CDPR_UNROLL
    for (int i = 0; i < Twelve::PIECES; i++) *reinterpret_cast<RowPiece*>(array + PIECE * i) = row.piece[i];
}

CDPR_INLINE Twelve operator+(const Twelve& a, const Twelve& b) {
    return each_piece([&](int i) -> RowPiece { return a.piece[i] + b.piece[i]; });
}
CDPR_INLINE Twelve operator-(const Twelve& a, const Twelve& b) {
    return each_piece([&](int i) -> RowPiece { return a.piece[i] - b.piece[i]; });
}
CDPR_INLINE Twelve operator*(double factor, const Twelve& a) {
    return each_piece([&](int i) -> RowPiece { return factor * a.piece[i]; });
}

}  // namespace cdpr::CDPR_TARGET
