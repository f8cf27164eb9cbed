// Rows of the winches and spans of the cables of one robot. SPDX-License-Identifier: Apache-2.0
//
// A cable consists of a winch, an exit and a span (`cdpr.cables`). A row of `chains` holds: kinds of winch and span
// (parts.hpp); the lowest tension, N: 0, or minus infinity for a leg that pushes; eight numbers of the winch, the first
// of which is cable per unit of the winch's coordinate, m/rad; eight numbers of the span.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/parts.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct ChainRow {
    static constexpr int WINCH_KIND = 0, SPAN_KIND = 1, LOWEST = 2, WINCH = 3, SPAN = 11, WIDTH = 19;

    const T* row;

    CDPR_INLINE T winch_kind() const { return row[WINCH_KIND]; }
    CDPR_INLINE T span_kind() const { return row[SPAN_KIND]; }
    CDPR_INLINE bool stretches() const { return !is(span_kind(), INEXTENSIBLE); }
    CDPR_INLINE T lowest() const { return row[LOWEST]; }
    CDPR_INLINE T per_turn() const { return row[WINCH]; }
    CDPR_INLINE const T* winch() const { return row + WINCH; }
    CDPR_INLINE const T* span() const { return row + SPAN; }
};

template <class T> CDPR_INLINE ChainRow<T> chain_row(const T* chains, int64_t i) {
    return {chains + i * ChainRow<T>::WIDTH};
}

}  // namespace cdpr::CDPR_TARGET
