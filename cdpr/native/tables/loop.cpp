// The loop, alone and side by side. SPDX-License-Identifier: Apache-2.0
#include <cdpr/analysis/rollouts/block.hpp>
#include <cdpr/analysis/rollouts/figures.hpp>
#include <cdpr/group.hpp>
#include <cdpr/simulation/step_kernel.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<StepKernel, step_kernel>("step_kernel"),
    entry<Lane, move_lane>("move_lane"),
    entry<Advance, advance>("advance"),
    entry<CountSample<double>, count_sample<double>>("count_sample"),
    entry<CountSamples, count_samples>("count_samples"),
#ifndef CDPR_ALONE
    entry<CountSample<Lanes>, count_sample<Lanes>>("count_sample_lanes"),
#endif
};

extern const cdpr_group loop = group(entries);

}  // namespace cdpr::CDPR_TARGET
