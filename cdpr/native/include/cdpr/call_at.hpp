// Call of an operation by its address. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdint.h>

#include <cdpr/table.h>
#include <cdpr/target.hpp>

namespace cdpr::CDPR_TARGET {

// Call an operation by its address and that of its struct.
CDPR_INLINE int call_at(int64_t operation, int64_t place, double time) {
    return reinterpret_cast<cdpr_operation>(operation)(reinterpret_cast<void*>(place), time);
}

}  // namespace cdpr::CDPR_TARGET
