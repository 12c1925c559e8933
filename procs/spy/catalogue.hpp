// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace cairn::spy {

/// What the message catalogue says of one channel.
struct CatalogueEntry {
  std::string type;     ///< "pose_t"
  bool steady = false;  ///< comes at some rate all the time, so that silence means something
};

/// Null for a channel that is not in the catalogue.
[[nodiscard]] const CatalogueEntry* catalogue_entry(std::string_view channel);

}  // namespace cairn::spy
