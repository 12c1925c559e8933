// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace cairn::evaluation {

/// One line of a text file that holds values, cut into its fields.
struct TableLine {
  std::string place;  ///< "file:line: ", to begin an error with
  std::vector<std::string_view> fields;
};

/// A text file of at most 1 GB as lines of fields between blanks or commas, without comments (#)
/// and blank lines.
class NumberTable {
 public:
  [[nodiscard]] static Result<NumberTable> read(const std::filesystem::path& file);

  [[nodiscard]] const std::vector<TableLine>& lines() const { return lines_; }

 private:
  std::vector<char> text_;
  std::vector<TableLine> lines_;
};

/// Field `index` as a finite number; the error names the place and the field, counted from 1.
[[nodiscard]] Result<double> number_at(const TableLine& line, std::size_t index);

/// Field `index` as a whole number.
[[nodiscard]] Result<std::int64_t> integer_at(const TableLine& line, std::size_t index);

}  // namespace cairn::evaluation
