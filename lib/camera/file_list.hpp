// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace cairn::camera {

using FileList = std::vector<std::filesystem::path>;

/// The files that match `pattern` (wildcards * ? [] in its last part) under `folder`, sorted by
/// name with runs of digits by their value, so that 9 comes before 10. None is an error.
[[nodiscard]] Result<FileList> list_files(const std::filesystem::path& folder,
                                          const std::string& pattern);

/// Nothing if left and right pair up, else an error that names the missing file where the names
/// tell it. Names pair when they are equal but for the extension, or carry equal numbers (left_17,
/// right_17); where neither is so, files pair by position. Names that are times must be equal.
[[nodiscard]] Result<void> check_pairs(const FileList& left, const FileList& right,
                                       bool names_are_times);

/// For files without times of their own: numbered evenly except for a few gaps, the gaps are
/// missing files, and the error names the first.
[[nodiscard]] Result<void> check_no_gap(const FileList& files);

}  // namespace cairn::camera
