// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/text_table.hpp"

#include <algorithm>

#include "procs/spy/printable.hpp"

namespace cairn::spy {
namespace {

constexpr std::size_t kGap = 2;

std::size_t total(const std::vector<std::size_t>& widths, const std::vector<bool>& shown) {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < widths.size(); ++i) sum += shown[i] ? widths[i] + kGap : 0;
  return sum - std::min(sum, kGap);
}

/// Which columns stay, so that the rest fits.
std::vector<bool> fitting(const std::vector<TableColumn>& columns,
                          const std::vector<std::size_t>& widths, std::size_t width) {
  std::vector<bool> shown(columns.size(), true);
  while (total(widths, shown) > width) {
    std::size_t first_to_go = columns.size();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const bool candidate = shown[i] && columns[i].expendable > 0;
      if (candidate && (first_to_go == columns.size() ||
                        columns[i].expendable > columns[first_to_go].expendable)) {
        first_to_go = i;
      }
    }
    if (first_to_go == columns.size()) break;
    shown[first_to_go] = false;
  }
  return shown;
}

}  // namespace

std::vector<std::size_t> TextTable::widths() const {
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::size_t width = width_of(columns_[i].title);
    for (const auto& row : rows_) width = std::max(width, width_of(row[i]));
    widths.push_back(width);
  }
  return widths;
}

std::vector<std::string> TextTable::lines(std::size_t width) const {
  const std::vector<std::size_t> column_widths = widths();
  const std::vector<bool> shown = fitting(columns_, column_widths, width);
  const auto line = [&](auto&& cell_of) {
    std::string text;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!shown[i]) continue;
      const std::string& cell = cell_of(i);
      const std::string padding(column_widths[i] - width_of(cell), ' ');
      if (!text.empty()) text += std::string(kGap, ' ');
      text += columns_[i].right_aligned ? padding + cell : cell + padding;
    }
    text.erase(text.find_last_not_of(' ') + 1);
    return shortened(text, width);
  };
  std::vector<std::string> lines;
  lines.push_back(line([&](std::size_t i) -> const std::string& { return columns_[i].title; }));
  for (const auto& row : rows_)
    lines.push_back(line([&](std::size_t i) -> const std::string& { return row[i]; }));
  return lines;
}

}  // namespace cairn::spy
