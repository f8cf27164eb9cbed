// Force and moment. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Wrench {
    Vector<T> force;   // N
    Vector<T> moment;  // N m
};

template <class T> CDPR_INLINE Wrench<T> wrench(const T* array) { return {vector(array), vector(array + 3)}; }

template <class T> CDPR_INLINE void store(Wrench<T> w, T* array) {
    store(w.force, array);
    store(w.moment, array + 3);
}

template <class T> CDPR_INLINE Wrench<T> operator+(Wrench<T> a, Wrench<T> b) {
    return {a.force + b.force, a.moment + b.moment};
}

}  // namespace cdpr::CDPR_TARGET
