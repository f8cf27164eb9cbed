// Mechanics of the platform. SPDX-License-Identifier: Apache-2.0
#include <cdpr/energy.hpp>
#include <cdpr/group.hpp>
#include <cdpr/inverse_dynamics.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<InverseDynamics<double>, static_cast<int (*)(InverseDynamics<double>&)>(inverse_dynamics)>(
        "inverse_dynamics"),
    entry<PlatformEnergy<double>, platform_energy<double>>("energy"),
};

extern const cdpr_group mechanics = group(entries);

}  // namespace CDPR_TARGET
}  // namespace cdpr
