// Matrices, stored row by row. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// View of memory owned by the caller. Rows begin `stride` numbers apart.
template <class T> struct Matrix {
    T* data;
    int64_t stride;

    CDPR_INLINE T& operator()(int64_t row, int64_t column) const { return data[row * stride + column]; }
    CDPR_INLINE T* operator[](int64_t row) const { return data + row * stride; }
    CDPR_INLINE Matrix from(int64_t row) const { return {data + row * stride, stride}; }
};

CDPR_INLINE void swap(double& a, double& b) {
    const double kept = a;
    a = b;
    b = kept;
}

}  // namespace cdpr::CDPR_TARGET
