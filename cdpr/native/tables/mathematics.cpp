// Shared mathematics. SPDX-License-Identifier: Apache-2.0
#include <cdpr/cross_products.hpp>
#include <cdpr/group.hpp>
#include <cdpr/positive_definite.hpp>
#include <cdpr/random_numbers.hpp>
#include <cdpr/rotations.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<CrossProducts<double>, cross_products<double>>("cross_products"),
    entry<Rotations<double>, rotations<double>>("rotations"),
    entry<QuaternionProducts<double>, quaternion_products<double>>("quaternion_products"),
    entry<RotationVectors<double>, rotation_vectors<double>>("rotation_vectors"),
    entry<Quaternions<double>, quaternions<double>>("quaternions"),
    entry<PositiveDefinite<double>, positive_definite<double>>("positive_definite"),
    entry<RandomNumbers<double>, uniform_numbers<double>>("uniform_numbers"),
    entry<RandomNumbers<double>, normal_numbers<double>>("normal_numbers"),
#ifndef CDPR_ALONE
    entry<RandomNumbers<Lanes>, uniform_numbers<Lanes>>("uniform_numbers_lanes"),
    entry<RandomNumbers<Lanes>, normal_numbers<Lanes>>("normal_numbers_lanes"),
#endif
};

extern const cdpr_group mathematics = group(entries);

}  // namespace cdpr::CDPR_TARGET
