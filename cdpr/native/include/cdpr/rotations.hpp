// Operations on rows of unit quaternions w, x, y, z. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Rotations {
    const T* quaternion;  // (k, 4)
    const T* vector;      // (k, 3), any unit
    T* rotated;           // (k, 3), R(q) v
    int64_t k;
    static constexpr char fields[] = "quaternion(k, 4), vector(k, 3), rotated(k, 3), k";
};

template <class T> inline int rotations(Rotations<T>& rows) {
    for (int64_t i = 0; i < rows.k; i++)
        store(rotate(quaternion(rows.quaternion + 4 * i), vector(rows.vector + 3 * i)), rows.rotated + 3 * i);
    return 0;
}

template <class T> struct QuaternionProducts {
    const T* left;   // (k, 4)
    const T* right;  // (k, 4), the rotation that comes first
    T* product;      // (k, 4)
    int64_t k;
    static constexpr char fields[] = "left(k, 4), right(k, 4), product(k, 4), k";
};

template <class T> inline int quaternion_products(QuaternionProducts<T>& rows) {
    for (int64_t i = 0; i < rows.k; i++)
        store(multiply(quaternion(rows.left + 4 * i), quaternion(rows.right + 4 * i)), rows.product + 4 * i);
    return 0;
}

template <class T> struct RotationVectors {
    const T* quaternion;  // (k, 4), of either sign
    T* vector;            // (k, 3), rad, at most pi long
    int64_t k;
    static constexpr char fields[] = "quaternion(k, 4), vector(k, 3), k";
};

template <class T> inline int rotation_vectors(RotationVectors<T>& rows) {
    for (int64_t i = 0; i < rows.k; i++) store(logarithm(quaternion(rows.quaternion + 4 * i)), rows.vector + 3 * i);
    return 0;
}

template <class T> struct Quaternions {
    const T* vector;  // (k, 3), rotation vectors, rad
    T* quaternion;    // (k, 4)
    int64_t k;
    static constexpr char fields[] = "vector(k, 3), quaternion(k, 4), k";
};

template <class T> inline int quaternions(Quaternions<T>& rows) {
    for (int64_t i = 0; i < rows.k; i++) store(exponential(vector(rows.vector + 3 * i)), rows.quaternion + 4 * i);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
