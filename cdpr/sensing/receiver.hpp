// Position of a point on the platform. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

struct PointOnPlatform {
    const double* state;  // (13), of the platform
    const double* point;  // (3), m, platform axes
    double* position;     // (3), m, world axes
    static constexpr char fields[] = "state(13), point(3), position(3)";
};

inline int point_on_platform(PointOnPlatform& p) {
    store(vector(p.state) + rotate(quaternion(p.state + 3), vector(p.point)), p.position);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
