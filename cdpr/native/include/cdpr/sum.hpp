// Sums: the single definition of their order. SPDX-License-Identifier: Apache-2.0
//
// Terms are added one after the other, first to last, on every processor and in every lane. Another order would give
// other bits.
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// Return start + term(begin) + ... + term(end - 1).
template <class T, class Term> CDPR_INLINE T sum(T start, int64_t begin, int64_t end, Term term) {
    for (int64_t i = begin; i < end; i++) start = start + term(i);
    return start;
}

// Return start - term(begin) - ... - term(end - 1).
template <class T, class Term> CDPR_INLINE T difference(T start, int64_t begin, int64_t end, Term term) {
    for (int64_t i = begin; i < end; i++) start = start - term(i);
    return start;
}

}  // namespace cdpr::CDPR_TARGET
