// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace cairn::camera {

/// One line of a text file that says something.
struct TextLine {
  int number = 0;  ///< from 1
  std::string text;
};

/// The lines of a file without blank ones, comments (#) and line ends of either kind.
[[nodiscard]] Result<std::vector<TextLine>> read_lines(const std::filesystem::path& file);

/// The numbers of a line, parted by blanks; the error says which word is none.
[[nodiscard]] Result<std::vector<double>> parse_numbers(std::string_view text);

/// "file:line: " for an error message.
[[nodiscard]] std::string place(const std::filesystem::path& file, const TextLine& line);

}  // namespace cairn::camera
