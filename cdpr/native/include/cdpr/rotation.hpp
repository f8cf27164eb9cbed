// Rotations as unit quaternions w, x, y, z. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

// Below this sine of the half angle the rotation vector is 2 (x, y, z) to 1e-16: the next term is sine^2 / 6.
constexpr double SMALL_SINE = 1e-8;

template <class T> struct Quaternion {
    T w, x, y, z;
};

template <class T> CDPR_INLINE Quaternion<T> quaternion(const T* array) {
    return {array[0], array[1], array[2], array[3]};
}

template <class T> CDPR_INLINE void store(Quaternion<T> q, T* array) {
    array[0] = q.w;
    array[1] = q.x;
    array[2] = q.y;
    array[3] = q.z;
}

// Inverse of a unit quaternion.
template <class T> CDPR_INLINE Quaternion<T> conjugate(Quaternion<T> q) { return {q.w, -q.x, -q.y, -q.z}; }

// Hamilton product: the rotation b, then a.
template <class T> CDPR_INLINE Quaternion<T> multiply(Quaternion<T> a, Quaternion<T> b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}

// R(q) v, by v + 2 w (a x v) + 2 a x (a x v) with the vector part a.
template <class T> CDPR_INLINE Vector<T> rotate(Quaternion<T> q, Vector<T> v) {
    const Vector<T> axis = {q.x, q.y, q.z};
    const Vector<T> t = T(2.0) * cross(axis, v);
    return v + q.w * t + cross(axis, t);
}

// Unit quaternion of a rotation vector, rad.
template <class T> CDPR_INLINE Quaternion<T> exponential(Vector<T> v) {
    const T half = 0.5 * length(v);
    const T scale = select(half < T(SMALL_SINE), T(0.5), 0.5 * sine(half) / half);
    return {cosine(half), scale * v.x, scale * v.y, scale * v.z};
}

// Rotation vector, rad, at most pi long, of a unit quaternion of either sign.
template <class T> CDPR_INLINE Vector<T> logarithm(Quaternion<T> q) {
    const T sine = square_root(q.x * q.x + q.y * q.y + q.z * q.z);
    const Truth<T> small = sine < T(SMALL_SINE);
    const T factor = select(small, T(2.0), 2.0 * angle_of(sine, absolute(q.w)) / select(small, T(1.0), sine));
    const T signed_factor = select(q.w < T(0.0), -factor, factor);
    return {signed_factor * q.x, signed_factor * q.y, signed_factor * q.z};
}

}  // namespace cdpr::CDPR_TARGET
