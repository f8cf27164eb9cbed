// Cables: exits and geometry. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/mechanics/geometry.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Exits<double>, exits<double>>("exits"),
    entry<Geometry<double>, geometry<double>>("geometry"),
    entry<MatrixRate<double>, matrix_rate<double>>("matrix_rate"),
    entry<CableWrench<double>, cable_wrench<double>>("cable_wrench"),
#ifndef CDPR_ALONE
    entry<Geometry<Lanes>, geometry<Lanes>>("geometry_lanes"),
#endif
};

extern const cdpr_group cables = group(entries);

}  // namespace cdpr::CDPR_TARGET
