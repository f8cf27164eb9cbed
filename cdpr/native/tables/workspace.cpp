// Workspaces. SPDX-License-Identifier: Apache-2.0
#include <cdpr/analysis/workspace/assess_poses.hpp>
#include <cdpr/analysis/workspace/connected.hpp>
#include <cdpr/analysis/workspace/octree.hpp>
#include <cdpr/group.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Assess, assess>("assess"),
    entry<ConnectedCells, connected_cells>("connected_cells"),
    entry<SettleBoxes, settle_boxes>("settle_boxes"),
    entry<BoxPoints, box_points>("box_points"),
    entry<DivideBoxes, divide_boxes>("divide_boxes"),
};

extern const cdpr_group workspace = group(entries);

}  // namespace cdpr::CDPR_TARGET
