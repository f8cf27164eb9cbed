// Tensions that hold the platform still at a pose: the feed-forward of cable_length. SPDX-License-Identifier:
// Apache-2.0
//
// They balance the weight within the limits, as near as possible to a pretension in each cable. Pretension 0 gives the
// distribution of least norm. If no tensions within the limits balance the weight, they are those of the nearest wrench
// (box_least_squares.hpp, which differs from the exact answer by 1e-5 of the load).
#pragma once

#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/tension/box_least_squares.hpp>

namespace cdpr::CDPR_TARGET {

struct Holding {
    const double* lines;     // (m, w), as in Geometry
    const int64_t* rows;     // (n), degrees of freedom: rows of the wrench matrix (6, m)
    const double* weights;   // (n): 1 for forces and 1 / characteristic length, 1/m, for moments
    const double* low;       // (m), N: limits minus the pretension
    const double* high;      // (m), N
    const double* inertial;  // (13), `Robot.inertial`
    const double* gravity;   // (3), m/s^2, world
    double* feed;            // (m), N: the tensions; unchanged if none are found
    double* still;           // (13), work space: the pose at rest
    double* whole_matrix;    // (6, m), work space
    double* lengths;         // (2, m), work space
    double* matrix;          // (n, m), work space
    double* whole_wrench;    // (6), work space
    double* wrench;          // (n), work space
    double* change;          // (m), work space
    double* results;         // (2), work space: status and steps
    BoxLeastSquaresSpace space;
    double pretension;  // N
    int64_t n;
    int64_t m;
    int64_t w;
    static constexpr auto fields = join(
        "lines(m, w >= 6), rows(n), weights(n), low(m), high(m), inertial(13), gravity(3), both feed(m), "
        "work still(13), work whole_matrix(6, m), work lengths(2, m), work matrix(n, m), work whole_wrench(6), "
        "work wrench(n), work change(m), work results(2), ",
        BoxLeastSquaresSpace::fields, ", pretension, n, m, w");

    CDPR_INLINE Geometry<double> cables() const { return {lines, still, whole_matrix, lengths, lengths + m, m, w}; }
    CDPR_INLINE BoxLeastSquares nearest() const {
        return {matrix, wrench, low, high, weights, change, results, results + 1, space, n, m};
    }
};

// Write the wrench matrix and the platform's weight minus the wrench of the pretension, at a pose (7); for all
// directions, and for the degrees of freedom. `beside` (6), if any, is a further wrench on the platform.
inline void write_load(const Holding& p, const double* pose, const double* beside) {
    for (int i = 0; i < 13; i++) p.still[i] = i < 7 ? pose[i] : 0.0;
    Geometry<double> cables = p.cables();
    geometry(cables);
    const Vector<double> none = no_vector<double>();
    store(inverse_dynamics<double>({p.inertial}, vector(p.gravity), quaternion(pose + 3), none, none, none),
          p.whole_wrench);
    for (int64_t j = 0; j < 6; j++) {
        const double* row = p.whole_matrix + j * p.m;
        p.whole_wrench[j] = difference(p.whole_wrench[j], 0, p.m, [&](int64_t i) { return row[i] * p.pretension; });
        if (beside != nullptr) p.whole_wrench[j] -= beside[j];
    }
    for (int64_t k = 0; k < p.n; k++) {
        p.wrench[k] = p.whole_wrench[p.rows[k]];
        for (int64_t i = 0; i < p.m; i++) p.matrix[k * p.m + i] = p.whole_matrix[p.rows[k] * p.m + i];
    }
}

// Write the tensions for a pose (7): position, m, and quaternion. If none are found, the previous ones are kept.
inline void hold(const Holding& p, const double* pose, const double* beside = nullptr) {
    write_load(p, pose, beside);
    if (bounded::find(p.nearest()) < 0) return;
    for (int64_t i = 0; i < p.m; i++) p.feed[i] = p.pretension + p.change[i];
}

}  // namespace cdpr::CDPR_TARGET
