// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace cairn::spy {

inline constexpr std::size_t kAnyWidth = std::numeric_limits<std::size_t>::max();

struct TableColumn {
  std::string title;
  bool right_aligned = false;
  /// Where the table does not fit, the columns of the highest number go first; 0 stays.
  int expendable = 0;
};

/// Rows of printable text under titles.
class TextTable {
 public:
  explicit TextTable(std::vector<TableColumn> columns) : columns_{std::move(columns)} {}

  /// One cell for each column.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  /// The titles, then the rows; no line is wider than `width`.
  [[nodiscard]] std::vector<std::string> lines(std::size_t width = kAnyWidth) const;

 private:
  [[nodiscard]] std::vector<std::size_t> widths() const;

  std::vector<TableColumn> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace cairn::spy
