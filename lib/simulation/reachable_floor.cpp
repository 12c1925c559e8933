// SPDX-License-Identifier: Apache-2.0
#include "simulation/reachable_floor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "simulation/upright_line.hpp"

namespace cairn::simulation {
namespace {

constexpr double kLine_m = 0.01;
constexpr int kLinesPerCell = 5;
constexpr int kLinesPerBin = 25;
constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
/// Larger worlds than 300 x 300 m are refused: every square centimetre has a line.
constexpr double kMaxSize_m = 300;
constexpr std::array<std::array<int, 2>, 4> kNeighbours{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

/// The plan of a world, with the boxes that stand in each square of it.
class Plan {
 public:
  explicit Plan(const World& world) : world_{world} {
    for (const Box& box : world.boxes) extent_.extend(extent_of(box));
    // A line of nothing all round.
    corner_m = extent_.min().array() - kLine_m;
    const Eigen::Vector2d size_m = extent_.sizes().array() + 2 * kLine_m;
    if (!(size_m.maxCoeff() < kMaxSize_m)) return;
    const auto lines = [](double m) {
      return kLinesPerBin * (static_cast<int>(m / (kLine_m * kLinesPerBin)) + 1);
    };
    cols = lines(size_m.x());
    rows = lines(size_m.y());
    bins_.resize(static_cast<std::size_t>(cols / kLinesPerBin * (rows / kLinesPerBin)));
    for (std::uint32_t i = 0; i < world.boxes.size(); ++i) put(i);
  }

  Eigen::Vector2d corner_m;
  int cols = 0;
  int rows = 0;

  [[nodiscard]] Eigen::Vector2d at_m(int col, int row) const {
    return corner_m + kLine_m * Eigen::Vector2d(col + 0.5, row + 0.5);
  }

  /// Height of the ground of a line for a walker that comes from a line beside it with ground at
  /// `from_m`; not a number where it cannot go.
  [[nodiscard]] float ground_m(int col, int row, double from_m, const Walker& walker) const {
    const Eigen::Vector2d at = at_m(col, row);
    const double flattest = std::cos(walker.max_slope_rad);
    const double limit_m = from_m + walker.max_step_m;
    double ground = -std::numeric_limits<double>::infinity();
    bool level = false;
    double ceiling = std::numeric_limits<double>::infinity();
    for (const std::uint32_t index : bin(col, row)) {
      const auto inside = upright_line_in(world_.boxes[index], at);
      if (!inside) continue;
      if (inside->high_m > limit_m) {
        ceiling = std::min(ceiling, inside->low_m);
      } else if (inside->high_m > ground) {
        ground = inside->high_m;
        level = inside->top_cosine >= flattest;
      }
    }
    if (!level || ground < from_m - walker.max_step_m || ceiling < ground + walker.height_m) {
      return kNowhere;
    }
    return static_cast<float>(ground);
  }

 private:
  static Eigen::AlignedBox2d extent_of(const Box& box) {
    Eigen::AlignedBox2d extent;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      extent.extend(
          Eigen::Vector2d((box.T_world_box * side.cwiseProduct(box.half_size_m)).head<2>()));
    }
    return extent;
  }

  void put(std::uint32_t index) {
    const Eigen::AlignedBox2d extent = extent_of(world_.boxes[index]);
    const auto bin_of = [this](const Eigen::Vector2d& point_m) {
      return Eigen::Vector2i(((point_m - corner_m) / (kLine_m * kLinesPerBin)).cast<int>());
    };
    const Eigen::Vector2i low = bin_of(extent.min());
    const Eigen::Vector2i high = bin_of(extent.max());
    for (int y = low.y(); y <= std::min(high.y(), rows / kLinesPerBin - 1); ++y) {
      for (int x = low.x(); x <= std::min(high.x(), cols / kLinesPerBin - 1); ++x) {
        bins_[static_cast<std::size_t>(y * (cols / kLinesPerBin) + x)].push_back(index);
      }
    }
  }

  [[nodiscard]] const std::vector<std::uint32_t>& bin(int col, int row) const {
    return bins_[static_cast<std::size_t>(row / kLinesPerBin * (cols / kLinesPerBin) +
                                          col / kLinesPerBin)];
  }

  const World& world_;
  Eigen::AlignedBox2d extent_;
  std::vector<std::vector<std::uint32_t>> bins_;
};

/// Calls visit(from, to) for each neighbour of what has been reached, from the start on, and goes
/// on from where it says true.
template <class Visit>
void spread(cv::Point start, cv::Size size, const Visit& visit) {
  std::vector<cv::Point> open{start};
  for (std::size_t i = 0; i < open.size(); ++i) {
    const cv::Point from = open[i];
    for (const auto& [x, y] : kNeighbours) {
      const cv::Point to(from.x + x, from.y + y);
      if (to.x < 0 || to.y < 0 || to.x >= size.width || to.y >= size.height) continue;
      if (visit(from, to)) open.push_back(to);
    }
  }
}

/// Height of the ground of every line that a walker without extent gets to.
cv::Mat_<float> ground_from(const Plan& plan, cv::Point start, const Walker& walker) {
  cv::Mat_<float> ground(plan.rows, plan.cols, kNowhere);
  ground(start) = plan.ground_m(start.x, start.y, 0, walker);
  if (std::isnan(ground(start))) return ground;
  spread(start, ground.size(), [&](cv::Point from, cv::Point to) {
    if (!std::isnan(ground(to))) return false;
    ground(to) = plan.ground_m(to.x, to.y, ground(from), walker);
    return !std::isnan(ground(to));
  });
  return ground;
}

/// 255 where the ground is reached and goes on within a step to all sides that are reached too.
cv::Mat_<std::uint8_t> standable_lines(const cv::Mat_<float>& ground, const Walker& walker) {
  cv::Mat_<std::uint8_t> standable(ground.size(), std::uint8_t{0});
  const cv::Rect all({0, 0}, ground.size());
  for (int row = 0; row < ground.rows; ++row) {
    for (int col = 0; col < ground.cols; ++col) {
      const auto falls_off = [&](const std::array<int, 2>& neighbour) {
        const cv::Point beside(col + neighbour[0], row + neighbour[1]);
        return all.contains(beside) &&
               std::abs(ground(beside) - ground(row, col)) > walker.max_step_m;
      };
      const bool edge = std::any_of(kNeighbours.begin(), kNeighbours.end(), falls_off);
      standable(row, col) = std::isnan(ground(row, col)) || edge ? 0 : 255;
    }
  }
  return standable;
}

/// Where the mask is not 0: distance to the nearest 0, in lines, from middle to middle.
cv::Mat_<float> distance_in_lines(const cv::Mat_<std::uint8_t>& mask) {
  cv::Mat_<float> distance;
  cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

std::string spot(const Eigen::Vector2d& at_m) {
  return "(" + std::to_string(at_m.x()) + ", " + std::to_string(at_m.y()) + ")";
}

}  // namespace

Result<ReachableFloor> ReachableFloor::flood(const World& world, const Eigen::Vector2d& start_m,
                                             const Walker& walker) {
  const Plan plan(world);
  if (plan.cols == 0) return fail("floor: the world is larger than 300 m");
  const Eigen::Vector2i first = ((start_m - plan.corner_m) / kLine_m).array().floor().cast<int>();
  const cv::Point start(first.x(), first.y());
  const cv::Mat_<float> ground = cv::Rect(0, 0, plan.cols, plan.rows).contains(start)
                                     ? ground_from(plan, start, walker)
                                     : cv::Mat_<float>(plan.rows, plan.cols, kNowhere);
  const cv::Mat_<std::uint8_t> standable = standable_lines(ground, walker);
  const double radius = walker.radius_m / kLine_m;
  cv::Mat_<std::uint8_t> fits;
  cv::compare(distance_in_lines(standable), radius + 0.5, fits, cv::CMP_GE);
  if (!cv::Rect(0, 0, plan.cols, plan.rows).contains(start) || fits(start) == 0) {
    return fail("floor: nothing of radius " + std::to_string(walker.radius_m) +
                " m can stand on the ground at " + spot(start_m));
  }
  ReachableFloor floor;
  floor.corner_m_ = plan.corner_m;
  floor.cols_ = plan.cols;
  floor.rows_ = plan.rows;
  cv::Mat_<std::uint8_t> room(fits.size(), std::uint8_t{0});
  room(start) = 1;
  spread(start, room.size(), [&](cv::Point, cv::Point to) {
    if (room(to) != 0 || fits(to) == 0) return false;
    room(to) = 1;
    return true;
  });
  floor.room_.assign(room.begin(), room.end());
  cv::Mat_<std::uint8_t> no_room;
  cv::compare(room, 0, no_room, cv::CMP_EQ);
  const cv::Mat_<float> from_room = distance_in_lines(no_room);
  floor.cell_of_.assign(
      static_cast<std::size_t>(plan.cols / kLinesPerCell * (plan.rows / kLinesPerCell)), -1);
  for (std::size_t i = 0; i < floor.cell_of_.size(); ++i) {
    const int cell_cols = plan.cols / kLinesPerCell;
    const int col = static_cast<int>(i) % cell_cols * kLinesPerCell + kLinesPerCell / 2;
    const int row = static_cast<int>(i) / cell_cols * kLinesPerCell + kLinesPerCell / 2;
    if (standable(row, col) == 0 || from_room(row, col) > radius) continue;
    floor.cell_of_[i] = static_cast<std::int32_t>(floor.cells_.size());
    Eigen::Vector3d middle_m;
    middle_m << plan.at_m(col, row), static_cast<double>(ground(row, col));
    floor.cells_.push_back({middle_m, static_cast<int>(i)});
  }
  return floor;
}

bool ReachableFloor::has_room_at(const Eigen::Vector2d& at_m) const {
  const Eigen::Vector2d line = ((at_m - corner_m_) / kLine_m).array().floor();
  if (!(line.minCoeff() >= 0 && line.x() < cols_ && line.y() < rows_)) return false;
  return room_[static_cast<std::size_t>(line.y()) * static_cast<std::size_t>(cols_) +
               static_cast<std::size_t>(line.x())] != 0;
}

int ReachableFloor::cell_at(const Eigen::Vector2d& at_m) const {
  const Eigen::Vector2d cell = ((at_m - corner_m_) / kCell_m).array().floor();
  const int cols = cols_ / kLinesPerCell;
  if (!(cell.minCoeff() >= 0 && cell.x() < cols && cell.y() < rows_ / kLinesPerCell)) return -1;
  return cell_of_[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(cols) +
                  static_cast<std::size_t>(cell.x())];
}

}  // namespace cairn::simulation
