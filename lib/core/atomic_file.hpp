// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/result.hpp"

namespace cairn {

/// Writes to a temporary beside `path`, syncs it, renames it over `path` and syncs the folder:
/// after a crash at any moment `path` holds either the old or the new bytes, whole. On error `path`
/// is untouched and the temporary gone.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& path,
                                                 std::span<const std::uint8_t> bytes);

/// All bytes of a file; the error names the path and the reason. Files over `max_bytes` are
/// refused.
[[nodiscard]] Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path,
                                                          std::size_t max_bytes = std::size_t{1}
                                                                                  << 32);

}  // namespace cairn
