// Cross products, row by row. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct CrossProducts {
    const T* left;   // (n, 3)
    const T* right;  // (n, 3)
    T* product;      // (n, 3)
    int64_t n;
    static constexpr char fields[] = "left(n, 3), right(n, 3), product(n, 3), n";
};

template <class T> inline int cross_products(CrossProducts<T>& problem) {
    for (int64_t i = 0; i < problem.n; i++)
        store(cross(vector(problem.left + 3 * i), vector(problem.right + 3 * i)), problem.product + 3 * i);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
