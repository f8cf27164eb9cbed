// Vectors in space. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Vector {
    T x, y, z;
};

template <class T> CDPR_INLINE Vector<T> vector(const T* array) { return {array[0], array[1], array[2]}; }

template <class T> CDPR_INLINE void store(Vector<T> v, T* array) {
    array[0] = v.x;
    array[1] = v.y;
    array[2] = v.z;
}

template <class T> CDPR_INLINE Vector<T> operator+(Vector<T> a, Vector<T> b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

template <class T> CDPR_INLINE Vector<T> operator-(Vector<T> a, Vector<T> b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

template <class T> CDPR_INLINE Vector<T> operator*(T factor, Vector<T> v) {
    return {factor * v.x, factor * v.y, factor * v.z};
}

template <class T> CDPR_INLINE Vector<T> operator/(Vector<T> v, T divisor) {
    return {v.x / divisor, v.y / divisor, v.z / divisor};
}

template <class T> CDPR_INLINE T dot(Vector<T> a, Vector<T> b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

template <class T> CDPR_INLINE Vector<T> cross(Vector<T> a, Vector<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T> CDPR_INLINE T length(Vector<T> v) { return square_root(dot(v, v)); }

template <class T> CDPR_INLINE Vector<T> select(Truth<T> condition, Vector<T> a, Vector<T> b) {
    return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

// A v; A is 3 x 3, row by row.
template <class T> CDPR_INLINE Vector<T> product(const T* A, Vector<T> v) {
    return {dot(vector(A), v), dot(vector(A + 3), v), dot(vector(A + 6), v)};
}

}  // namespace cdpr::CDPR_TARGET
