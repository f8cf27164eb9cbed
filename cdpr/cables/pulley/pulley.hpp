// Pulley that swivels about the line on which its cable arrives. SPDX-License-Identifier: Apache-2.0
//
// Geometry, derivation and sources: the docstring of this package. World axes, SI units. `numbers`: radius, unit vector
// of the axis, and a unit vector perpendicular to it for points on the axis, which do not determine a plane. With
// friction, further: coefficient mu of the groove; k of the bearing, above 1 for one that does not turn; 1 / friction
// speed, s/m.
#pragma once

#include <cdpr/cables/exit_result.hpp>
#include <cdpr/elementary.hpp>

namespace cdpr::CDPR_TARGET {

struct Pulley {
    static constexpr int RADIUS = 0, AXIS = 1, SIDE = 4, COUNT = 7;
    static constexpr int GROOVE = 7, BEARING = 8, STEEPNESS = 9, COUNT_WITH_FRICTION = 10;
    static constexpr double NO_SLIP = 100.0;  // mu of a groove in which no cable slips

    // The wrap angle is counted from minus a quarter turn: round-off about 0 is no full turn.
    static constexpr double TURN = 6.283185307179586, FIRST = -1.5707963267948966;

    // Plane of the cable: its direction away from the axis, the tip in it as seen from the centre (c, z), the length of
    // the tangent, and the wrap angle.
    template <class T> struct Plane {
        Vector<T> out;
        T c, z, tangent, sine, cosine;
    };

    template <class T> static CDPR_INLINE Plane<T> plane(Vector<T> anchor, const T* numbers, Vector<T> tip) {
        const T radius = numbers[RADIUS];
        const Vector<T> axis = vector(numbers + AXIS), d = tip - anchor;
        const T z = dot(d, axis);
        const Vector<T> away = d - z * axis;
        const T x = length(away), c = x - radius;
        const Vector<T> out = select(x > T(0.0), (1.0 / x) * away, vector(numbers + SIDE));
        const T tangent = square_root(x * (x - 2.0 * radius) + z * z);
        const T per = 1.0 / (c * c + z * z);
        return {out, c, z, tangent, per * (tangent * c + radius * z), per * (tangent * z - radius * c)};
    }

    // Return the point where the cable leaves the groove.
    template <class T> static CDPR_INLINE Vector<T> leave(Vector<T> anchor, const T* numbers, Vector<T> tip) {
        return point(anchor, numbers, plane(anchor, numbers, tip));
    }

    // Return that point, and the length of cable on the groove, m; NaN for wrap angles above 270 degrees.
    template <class T> static CDPR_INLINE ExitResult<T> lead(Vector<T> anchor, const T* numbers, Vector<T> tip) {
        const Plane<T> at = plane(anchor, numbers, tip);
        const Truth<T> beyond = (at.z < T(0.0)) & (at.sine < T(0.0)) & (at.cosine > T(0.0));
        const T angle = select(beyond, T(NOT_A_NUMBER), angle_of(at.sine, at.cosine));
        const T wrap = select(angle >= T(FIRST), angle, angle + TURN);
        return {point(anchor, numbers, at), numbers[RADIUS] * wrap, select(beyond, T(NOT_A_NUMBER), at.sine),
                at.cosine};
    }

    // Return the velocity of that point while the tip moves with V, m/s: the tangent turns with the component of V
    // across it, the plane with the component out of it.
    template <class T>
    static CDPR_INLINE Vector<T> carry(Vector<T> anchor, const T* numbers, Vector<T> tip, Vector<T> V) {
        const T radius = numbers[RADIUS];
        const Vector<T> axis = vector(numbers + AXIS);
        const Plane<T> at = plane(anchor, numbers, tip);
        const T forth = dot(V, at.out), along = dot(V, axis);
        const T turn = radius * (at.cosine * forth - at.sine * along) / at.tangent;
        const T far = at.c + radius;
        const T swing = select(far > T(0.0), radius * (1.0 - at.cosine) / far, T(0.0));
        return turn * (at.sine * at.out + at.cosine * axis) + swing * (V - forth * at.out - along * axis);
    }

    // Return the tension towards the winch, as a multiple of that towards the platform, of a cable that moves towards
    // the platform at a speed, m/s, from sine and cosine of the wrap angle. The groove slips or the bearing turns,
    // whichever takes less.
    template <class T> static CDPR_INLINE T friction(const T* numbers, T sine, T cosine, T speed) {
        const T share = elementary::hyperbolic_tangent(numbers[STEEPNESS] * speed);
        const Truth<T> wheel = numbers[BEARING] < T(1.0), groove = numbers[GROOVE] < T(NO_SLIP);
        T turns = 1.0;
        if (any(wheel)) turns = turning(share * numbers[BEARING], sine, cosine);
        if (!any(groove)) return turns;
        const T angle = elementary::angle_of_turn(sine, cosine);
        const T slips = elementary::exponential(-share * numbers[GROOVE] * angle);
        const T less = select(speed > T(0.0), larger(slips, turns), smaller(slips, turns));
        return select(wheel, select(groove, less, turns), slips);
    }

    // Return that multiple for a bearing that turns: with x as in the docstring, (sqrt(1 + x^2) - x)^2.
    template <class T> static CDPR_INLINE T turning(T k, T sine, T cosine) {
        const T root = square_root(0.5 + 0.5 * absolute(cosine));  // cosine of half the angle, or its sine
        const T half = select(cosine > T(0.0), larger(0.5 * sine / root, T(0.0)), root);
        const T rest = (1.0 - k) * (1.0 + k), across = k * half;
        const T high = square_root(rest + across * across) - across;
        return high * high / rest;
    }

    template <class T> static CDPR_INLINE Vector<T> point(Vector<T> anchor, const T* numbers, Plane<T> at) {
        const T radius = numbers[RADIUS];
        return anchor + (radius * (1.0 - at.cosine)) * at.out + (radius * at.sine) * vector(numbers + AXIS);
    }
};

}  // namespace cdpr::CDPR_TARGET
