// Desired motion. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/trajectory/block_tridiagonal.hpp>
#include <cdpr/trajectory/trajectory.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<DesiredMotion, desired_motion>("desired_motion"),
    entry<StoppingMotion, stopping_motion>("stopping_motion"),
    entry<SegmentSamples, segment_samples>("segment_samples"),
    entry<BlockTridiagonal, block_tridiagonal>("block_tridiagonal"),
};

extern const cdpr_group trajectory = group(entries);

}  // namespace cdpr::CDPR_TARGET
