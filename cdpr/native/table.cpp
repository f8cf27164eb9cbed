// All operations, compiled once per instruction set. SPDX-License-Identifier: Apache-2.0
//
// NAME takes doubles; NAME_lanes takes eight problems side by side (lanes.hpp). One file of tables/ for each group.
#include <cdpr/table.h>
#include <cdpr/instruction_set.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

extern const cdpr_group mathematics, mechanics, cables, tension, solvers, controllers, backends, simulation, trajectory;

static const cdpr_group* const groups[] = {&mathematics, &mechanics, &cables,     &tension,   &solvers,
                                           &controllers, &backends,  &simulation, &trajectory};

extern const cdpr_table table;
const cdpr_table table = {CDPR_TARGET_NAME, groups, sizeof(groups) / sizeof(groups[0])};

}  // namespace CDPR_TARGET
}  // namespace cdpr
