// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn::planning {

/// Side of a column of ground [m]. Cell (x, y) covers [x, x+1) * kCell_m along each axis of the
/// map.
inline constexpr double kCell_m = 0.05;

struct Cell {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend constexpr auto operator<=>(const Cell&, const Cell&) = default;
};

[[nodiscard]] inline Cell cell_at(const Eigen::Vector2d& point_m) {
  return {static_cast<std::int32_t>(std::floor(point_m.x() / kCell_m)),
          static_cast<std::int32_t>(std::floor(point_m.y() / kCell_m))};
}

[[nodiscard]] inline Eigen::Vector2d centre_m(Cell cell) {
  return {(cell.x + 0.5) * kCell_m, (cell.y + 0.5) * kCell_m};
}

/// A rectangle of cells, and their order in arrays: along x first.
struct CellBox {
  std::int32_t x0 = 0;
  std::int32_t y0 = 0;
  std::int32_t width = 0;
  std::int32_t height = 0;

  [[nodiscard]] bool contains(Cell cell) const {
    return cell.x >= x0 && cell.y >= y0 && cell.x < x0 + width && cell.y < y0 + height;
  }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  /// Of a cell that the box contains.
  [[nodiscard]] std::size_t index(Cell cell) const {
    return static_cast<std::size_t>(cell.y - y0) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(cell.x - x0);
  }
  [[nodiscard]] Cell cell(std::size_t index) const {
    const auto columns = static_cast<std::size_t>(width);
    return {x0 + static_cast<std::int32_t>(index % columns),
            y0 + static_cast<std::int32_t>(index / columns)};
  }
  friend bool operator==(const CellBox&, const CellBox&) = default;
};

/// One value for each cell of a box.
template <class T>
struct CellGrid {
  CellBox box;
  std::vector<T> values;

  CellGrid() = default;
  CellGrid(const CellBox& of, T value) : box{of}, values(of.size(), value) {}

  [[nodiscard]] T at(Cell cell, T outside) const {
    return box.contains(cell) ? values[box.index(cell)] : outside;
  }
};

struct CellStep {
  std::int32_t x;
  std::int32_t y;
};

inline constexpr CellStep kFourSteps[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
inline constexpr CellStep kEightSteps[] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                           {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

[[nodiscard]] constexpr Cell operator+(Cell cell, CellStep step) {
  return {cell.x + step.x, cell.y + step.y};
}

}  // namespace cairn::planning
