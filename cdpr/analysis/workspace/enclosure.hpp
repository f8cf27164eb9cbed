// Enclosures of numbers that depend on the position in a box. SPDX-License-Identifier: Apache-2.0
//
// Taylor models of first order: anywhere in a box with half sides h, with the platform at a distance d from the middle,
// the number is c + x d_x / h_x + y d_y / h_y + z d_z / h_z, within r. Second-order terms and round-off are in r, so
// that conclusions from a model are proved (Makino and Berz, Int. J. Pure Appl. Math. 4, 2003). The proofs rely on the
// order of each operation.
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

// Eight units in the last place: above the error of a sum of four rounded products, as a share of the sum of absolute
// values.
constexpr double ROUNDED = 0x1p-50;
// Below this a product may have lost all its digits.
constexpr double LOST = 1e-290;

struct Model {
    double c, x, y, z, r;

    // Largest first-order change of the number from the middle of the box.
    CDPR_INLINE double spread() const { return absolute(x) + absolute(y) + absolute(z); }

    // Largest absolute value of the number.
    CDPR_INLINE double largest() const { return (absolute(c) + spread() + r) * (1.0 + ROUNDED); }
};

// Rows of five numbers in work space.
CDPR_INLINE Model model(const double* row) { return {row[0], row[1], row[2], row[3], row[4]}; }
CDPR_INLINE void store(const Model& a, double* row) {
    row[0] = a.c;
    row[1] = a.x;
    row[2] = a.y;
    row[3] = a.z;
    row[4] = a.r;
}

CDPR_INLINE Model operator+(const Model& a, const Model& b) {
    const double c = a.c + b.c, x = a.x + b.x, y = a.y + b.y, z = a.z + b.z;
    const double r = a.r + b.r + ROUNDED * (absolute(c) + absolute(x) + absolute(y) + absolute(z));
    return {c, x, y, z, r * (1.0 + ROUNDED)};
}

CDPR_INLINE Model operator*(const Model& a, const Model& b) {
    const double p = absolute(a.c), q = absolute(b.c), s = a.spread(), t = b.spread();
    double r = p * b.r + q * a.r + (s + a.r) * (t + b.r);
    r += ROUNDED * (p * (q + t) + q * s) + LOST;
    return {a.c * b.c, a.c * b.x + b.c * a.x, a.c * b.y + b.c * a.y, a.c * b.z + b.c * a.z, r * (1.0 + ROUNDED)};
}

CDPR_INLINE Model operator*(double s, const Model& a) {
    const double r = absolute(s) * (a.r + ROUNDED * (absolute(a.c) + a.spread())) + LOST;
    return {s * a.c, s * a.x, s * a.y, s * a.z, r * (1.0 + ROUNDED)};
}

// Return 1 / |v - d|, each entry of v known to within `error`; r is infinite if it may be 1 / 0.
//
// The second derivative of 1 / |v| is at most 2 / |v|^3 along any direction.
inline Model inverse_distance(Vector<double> v, Vector<double> h, double error) {
    const double distance = length(v), half = length(h) * (1.0 + ROUNDED);
    const double near = (distance * (1.0 - ROUNDED) - half - 2.0 * error) * (1.0 - ROUNDED);
    if (!(near > 0.0)) return {0.0, 0.0, 0.0, 0.0, INFINITE};
    const double c = 1.0 / distance, cube = c * c * c;
    const double x = cube * v.x * h.x, y = cube * v.y * h.y, z = cube * v.z * h.z, far = 1.0 / near;
    double r = half * half * far * far * far + 2.0 * error * far * far * (1.0 + 2.0 * half * far);
    r += 2.0 * ROUNDED * (c + absolute(x) + absolute(y) + absolute(z)) + LOST;
    return {c, x, y, z, r * (1.0 + 4.0 * ROUNDED)};
}

}  // namespace cdpr::CDPR_TARGET
