// Mathematics that parts share. SPDX-License-Identifier: Apache-2.0
#include <cdpr/cross_products.hpp>
#include <cdpr/group.hpp>
#include <cdpr/positive_definite.hpp>
#include <cdpr/rotations.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<CrossProducts<double>, cross_products<double>>("cross_products"),
    entry<Rotations<double>, rotations<double>>("rotations"),
    entry<Rotations<Lanes>, rotations<Lanes>>("rotations_lanes"),
    entry<QuaternionProducts<double>, quaternion_products<double>>("quaternion_products"),
    entry<QuaternionProducts<Lanes>, quaternion_products<Lanes>>("quaternion_products_lanes"),
    entry<RotationVectors<double>, rotation_vectors<double>>("rotation_vectors"),
    entry<RotationVectors<Lanes>, rotation_vectors<Lanes>>("rotation_vectors_lanes"),
    entry<Quaternions<double>, quaternions<double>>("quaternions"),
    entry<Quaternions<Lanes>, quaternions<Lanes>>("quaternions_lanes"),
    entry<PositiveDefinite<double>, positive_definite<double>>("positive_definite"),
    entry<PositiveDefinite<Lanes>, positive_definite<Lanes>>("positive_definite_lanes"),
};

extern const cdpr_group mathematics = group(entries);

}  // namespace cdpr::CDPR_TARGET
