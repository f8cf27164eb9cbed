// Answer of a span whose force on the platform is not along its chord. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/vector.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

template <class T> struct BentCable {
    Vector<T> force;  // N, on the platform, world axes
    T tension;        // N, at the winch
};

}  // namespace CDPR_TARGET
}  // namespace cdpr
