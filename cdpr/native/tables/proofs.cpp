// Workspaces: rays of free positions, and proofs of boxes. SPDX-License-Identifier: Apache-2.0
#include <cdpr/analysis/workspace/enclosures.hpp>
#include <cdpr/analysis/workspace/proofs.hpp>
#include <cdpr/analysis/workspace/tracing.hpp>
#include <cdpr/group.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<ProveBoxes, prove>("prove"),
    entry<ModelArithmetic, model_arithmetic>("model_arithmetic"),
    entry<InverseDistances, inverse_distances>("inverse_distances"),
    entry<RaySearch, search_rays>("search_rays"),
};

extern const cdpr_group proofs = group(entries);

}  // namespace cdpr::CDPR_TARGET
