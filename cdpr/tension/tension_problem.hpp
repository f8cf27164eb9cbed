// Tension distribution for one wrench at one pose. SPDX-License-Identifier: Apache-2.0
//
// W t = wrench with t_min <= t <= t_max; conventions: `cdpr.model`.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/matrix.hpp>
#include <cdpr/number.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

// Problem shared by the solvers in null-space form. A cable with equal limits is locked: its tension is given.
template <class T> struct TensionProblem {
    const T* matrix;       // (n, m), W, moments in N m per N
    const T* wrench;       // (n), N and N m
    const T* tension_min;  // (m), N
    const T* tension_max;  // (m), N
    T* tension;            // (m), N; undefined unless the status is OK
    T* status;             // (1), a Status
    T* basis;              // (m, m), work space: N, null_space.hpp
    T* box;                // (4, m), work space: a solution, the limits, a target
    T* factors;            // (n + 5, n + m), work space
    int64_t n;
    int64_t m;
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), tension_min(m), tension_max(m), tension(m), status(1), work basis(m, m), "
        "work box(4, m), work factors(n + 5, n + m), n, m";

    CDPR_INLINE Matrix<const T> W() const { return {matrix, m}; }
    CDPR_INLINE Matrix<T> N() const { return {basis, m}; }
    CDPR_INLINE Matrix<T> work_rows() const { return {factors, n + m}; }
    CDPR_INLINE T* center() const { return box; }
    CDPR_INLINE T* low() const { return box + m; }
    CDPR_INLINE T* high() const { return box + 2 * m; }
    CDPR_INLINE T* target() const { return box + 3 * m; }
    CDPR_INLINE T* spare() const { return factors; }  // of `reduce`; afterwards (n + 5)(n + m) free numbers
};

}  // namespace cdpr::CDPR_TARGET
