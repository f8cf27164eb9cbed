// Operations of one room, for the table of an instruction set. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/entry.hpp>
#include <cdpr/instruction_set.hpp>

namespace cdpr::CDPR_TARGET {

template <int64_t count> constexpr cdpr_group group(const cdpr_entry (&entries)[count]) { return {entries, count}; }

}  // namespace cdpr::CDPR_TARGET
