// Log: compression of messages. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/log/zstd.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<ZstdFrame, write_zstd>("write_zstd"),
};

extern const cdpr_group log = group(entries);

}  // namespace cdpr::CDPR_TARGET
