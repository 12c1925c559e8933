// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/grid_index.hpp"

namespace cairn::mapping {

/// What one frame did to bricks: entries with a member `index`, found by it. An entry is named by
/// its place, which is good until clear(); all() has them in the order in which they were added.
template <class Entry>
class BrickTable {
 public:
  BrickTable() { clear(); }

  void clear() {
    bricks_.clear();
    table_.assign(kTableSize > table_.size() ? kTableSize : table_.size(), kNone);
  }

  [[nodiscard]] std::uint32_t find_or_add(BrickIndex index) {
    std::size_t at = place(index);
    if (table_[at] == kNone) {
      if (2 * (bricks_.size() + 1) > table_.size()) {
        grow_table();
        at = place(index);
      }
      table_[at] = static_cast<std::uint32_t>(bricks_.size());
      bricks_.emplace_back().index = index;
    }
    return table_[at];
  }

  /// nullptr: no such entry.
  [[nodiscard]] Entry* find(BrickIndex index) {
    const std::uint32_t slot = table_[place(index)];
    return slot == kNone ? nullptr : &bricks_[slot];
  }

  [[nodiscard]] Entry& operator[](std::uint32_t brick) { return bricks_.data()[brick]; }
  [[nodiscard]] const std::vector<Entry>& all() const { return bricks_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kTableSize = 1024;

  [[nodiscard]] std::size_t place(BrickIndex index) const {
    constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15ULL;
    const std::size_t last = table_.size() - 1;
    std::size_t at = (packed(index) * kGoldenRatio) >> (64 - std::bit_width(last));
    while (table_[at] != kNone && bricks_[table_[at]].index != index) at = (at + 1) & last;
    return at;
  }

  void grow_table() {
    table_.assign(table_.size() * 2, kNone);
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      table_[place(bricks_[i].index)] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<Entry> bricks_;
  std::vector<std::uint32_t> table_;
};

}  // namespace cairn::mapping
