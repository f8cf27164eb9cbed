// Table of all operations, compiled once per instruction set. SPDX-License-Identifier: Apache-2.0
#include <cdpr/cross_products.hpp>
#include <cdpr/entry.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<CrossProducts<double>, cross_products<double>>("cross_products"),
};

extern const cdpr_table table;
const cdpr_table table = {CDPR_TARGET_NAME, entries, sizeof(entries) / sizeof(entries[0])};

}  // namespace CDPR_TARGET
}  // namespace cdpr
