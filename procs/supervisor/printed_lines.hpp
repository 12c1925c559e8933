// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cairn {

/// Follows what is printed into a file that grows.
class PrintedLines {
 public:
  static constexpr std::size_t kLongestLine = 1'000;
  static constexpr std::size_t kMostLines = 50;

  /// Begins behind what the file holds now.
  explicit PrintedLines(std::filesystem::path file);

  /// The whole lines since the last call, as printable text; of a flood the first 50, then one that
  /// says how many there were.
  [[nodiscard]] std::vector<std::string> take();

 private:
  std::filesystem::path file_;
  std::uintmax_t position_ = 0;
  std::string rest_;  ///< the beginning of a line whose end is not printed yet
};

}  // namespace cairn
