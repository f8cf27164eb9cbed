// Numbers with their derivative along one direction, a number type of the kernels. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct Dual {
    double value, change;

    Dual() = default;
    CDPR_INLINE Dual(double constant) : value(constant), change(0.0) {}
    CDPR_INLINE Dual(double number, double along) : value(number), change(along) {}
};

CDPR_INLINE Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.change + b.change}; }
CDPR_INLINE Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.change - b.change}; }
CDPR_INLINE Dual operator-(Dual a) { return {-a.value, -a.change}; }
CDPR_INLINE Dual operator*(Dual a, Dual b) { return {a.value * b.value, a.change * b.value + a.value * b.change}; }
CDPR_INLINE Dual operator/(Dual a, Dual b) {
    const double ratio = a.value / b.value;
    return {ratio, (a.change - ratio * b.change) / b.value};
}
CDPR_INLINE Dual& operator+=(Dual& a, Dual b) { return a = a + b; }
CDPR_INLINE Dual& operator-=(Dual& a, Dual b) { return a = a - b; }
CDPR_INLINE Dual& operator*=(Dual& a, Dual b) { return a = a * b; }
CDPR_INLINE bool operator<(Dual a, Dual b) { return a.value < b.value; }
CDPR_INLINE bool operator<=(Dual a, Dual b) { return a.value <= b.value; }
CDPR_INLINE bool operator>(Dual a, Dual b) { return a.value > b.value; }
CDPR_INLINE bool operator>=(Dual a, Dual b) { return a.value >= b.value; }
CDPR_INLINE bool operator==(Dual a, Dual b) { return a.value == b.value; }
CDPR_INLINE bool operator!=(Dual a, Dual b) { return a.value != b.value; }

CDPR_INLINE Dual select(bool condition, Dual a, Dual b) { return condition ? a : b; }
CDPR_INLINE double first(Dual number) { return number.value; }
CDPR_INLINE Dual absolute(Dual a) { return a.value < 0.0 ? -a : a; }
CDPR_INLINE Dual square_root(Dual a) {
    const double root = square_root(a.value);
    return {root, a.change / (2.0 * root)};
}
CDPR_INLINE Dual sine(Dual a) { return {sine(a.value), cosine(a.value) * a.change}; }
CDPR_INLINE Dual cosine(Dual a) { return {cosine(a.value), -sine(a.value) * a.change}; }
CDPR_INLINE Dual hyperbolic_tangent(Dual a) {
    const double t = hyperbolic_tangent(a.value);
    return {t, (1.0 - t * t) * a.change};
}
CDPR_INLINE Dual angle_of(Dual y, Dual x) {
    const double square = x.value * x.value + y.value * y.value;
    return {angle_of(y.value, x.value), (x.value * y.change - y.value * x.change) / square};
}

}  // namespace cdpr::CDPR_TARGET
