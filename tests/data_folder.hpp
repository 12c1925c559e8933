// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace cairn::testing {

/// Where the real recordings and stereo pairs lie: the environment's CAIRN_DATA, else shared/data
/// beside the project. Nothing where there is no such folder; a test that needs it then skips and
/// says so.
[[nodiscard]] inline std::optional<std::filesystem::path> data_folder() {
  const char* named = std::getenv("CAIRN_DATA");
  const std::filesystem::path folder =
      named != nullptr && *named != '\0'
          ? std::filesystem::path(named)
          : std::filesystem::path(CAIRN_SOURCE_DIR) / ".." / "shared" / "data";
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return std::nullopt;
  return folder;
}

}  // namespace cairn::testing
