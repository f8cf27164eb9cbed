// What a tension solver reports. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/target.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

// Numbered as cdpr.tension.Status. A function that returns a count returns minus a status where it fails.
enum Status { OK, INFEASIBLE, NOT_FOUND, UNSUPPORTED, BAD_INPUT };

}  // namespace CDPR_TARGET
}  // namespace cdpr
