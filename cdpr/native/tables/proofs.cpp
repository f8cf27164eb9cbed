// Workspaces: rays of free positions, and proofs of boxes. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/workspace/tracing.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<RaySearch, search_rays>("search_rays"),
};

extern const cdpr_group proofs = group(entries);

}  // namespace CDPR_TARGET
}  // namespace cdpr
