// Tensions of least norm, by the normal equations: t = W^T x with (W W^T) x = wrench.
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/status.hpp>

namespace least_norm {

struct Problem {
    const double* matrix;  // (n, m)
    const double* wrench;  // (n)
    const double* low;     // (m)
    const double* high;    // (m)
    double* tension;       // (m)
    int64_t n;
    int64_t m;
    double* normal;    // (n, n), work space
    double* solution;  // (n), work space
    static constexpr char fields[] =
        "matrix(n, m), wrench(n), low(m), high(m), tension(m), n, m, work normal(n, n), work solution(n)";
};

inline int solve(Problem& p) {
    const cdpr::Matrix<const double> W = {p.matrix, p.m};
    const cdpr::Matrix<double> A = {p.normal, p.n};
    for (int64_t k = 0; k < p.n; k++)
        for (int64_t j = 0; j <= k; j++) A(k, j) = cdpr::sum(0.0, 0, p.m, [&](int64_t i) { return W(k, i) * W(j, i); });
    if (!cdpr::factorise(A, p.n, 0.0)) return cdpr::NOT_FOUND;
    cdpr::solve(A, p.wrench, p.solution, p.n);
    for (int64_t i = 0; i < p.m; i++) {
        p.tension[i] = cdpr::sum(0.0, 0, p.n, [&](int64_t k) { return W(k, i) * p.solution[k]; });
        if (!cdpr::finite(p.tension[i])) return cdpr::NOT_FOUND;
    }
    return cdpr::OK;
}

}  // namespace least_norm
