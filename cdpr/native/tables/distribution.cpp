// Distribution of many rows. SPDX-License-Identifier: Apache-2.0
#include <cdpr/distribute_rows.hpp>
#include <cdpr/group.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<DistributedRows, distribute_rows>("distribute_rows"),
    entry<RowsSideBySide, distribute_rows_side_by_side>("distribute_rows_lanes"),
};

extern const cdpr_group distribution = group(entries);

}  // namespace cdpr::CDPR_TARGET
