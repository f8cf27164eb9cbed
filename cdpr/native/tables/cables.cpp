// Cables: exits and geometry. SPDX-License-Identifier: Apache-2.0
#include <cdpr/cables/bent_cables.hpp>
#include <cdpr/cables/drums.hpp>
#include <cdpr/group.hpp>
#include <cdpr/mechanics/geometry.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Exits<double>, exits<double>>("exits"),
    entry<Geometry<double>, geometry<double>>("geometry"),
    entry<MatrixRate<double>, matrix_rate<double>>("matrix_rate"),
    entry<CableWrench<double>, cable_wrench<double>>("cable_wrench"),
    entry<BentCables<double>, bent_cables<double>>("bent_cables"),
    entry<BentLengths<double>, bent_lengths<double>>("bent_lengths"),
    entry<DrumMotions, drum_motions>("drum_motions"),
    entry<DrumLengths, drum_lengths>("drum_lengths"),
#ifndef CDPR_ALONE
    entry<Geometry<Lanes>, geometry<Lanes>>("geometry_lanes"),
#endif
};

extern const cdpr_group cables = group(entries);

}  // namespace cdpr::CDPR_TARGET
