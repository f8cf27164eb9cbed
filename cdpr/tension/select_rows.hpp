// Rows of a wrench matrix for the degrees of freedom. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Selection {
    const int64_t* rows;   // (n), from 0 to 5
    const T* full_matrix;  // (6, m)
    const T* full_wrench;  // (6)
    T* matrix;             // (n, m)
    T* wrench;             // (n)
    int64_t n;
    int64_t m;
    static constexpr char fields[] = "rows(n), full_matrix(6, m), full_wrench(6), matrix(n, m), wrench(n), n, m";
};

template <class T> inline int select_rows(Selection<T>& p) {
    for (int64_t k = 0; k < p.n; k++) {
        const int64_t row = p.rows[k];
        if (row < 0 || row > 5) return code(T(double(BAD_INPUT)));
        p.wrench[k] = p.full_wrench[row];
        for (int64_t i = 0; i < p.m; i++) p.matrix[k * p.m + i] = p.full_matrix[row * p.m + i];
    }
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
