// Statuses of kernels. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

// Numbered as cdpr.tension.Status. A function that returns a count returns minus a status on failure.
enum Status { OK, INFEASIBLE, NOT_FOUND, UNSUPPORTED, BAD_INPUT };

// Return the code of a kernel: its status; for lanes, the bits of those that are not OK.
CDPR_INLINE int code(double status) { return int(status); }
#ifdef CDPR_LANES
CDPR_INLINE int code(const Lanes& status) { return bits(status != Lanes(double(OK))); }
#endif

}  // namespace cdpr::CDPR_TARGET
