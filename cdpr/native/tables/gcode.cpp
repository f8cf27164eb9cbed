// Planning of motions along the path of a program. SPDX-License-Identifier: Apache-2.0
#include <cdpr/gcode/pace.hpp>
#include <cdpr/gcode/polygon_splines.hpp>
#include <cdpr/group.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<Pace, pace>("pace"),
    entry<PolygonSplines, polygon_splines>("polygon_splines"),
};

extern const cdpr_group gcode = group(entries);

}  // namespace cdpr::CDPR_TARGET
