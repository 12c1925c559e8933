// SPDX-License-Identifier: Apache-2.0
#include "random_world.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <vector>

#include "simulation/reachable_floor.hpp"

namespace cairn::testing {
namespace {

constexpr double kWall_m = 0.1;
constexpr double kDoor_m = 0.95;

std::string text(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string text(const char* format, ...) {
  char line[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return line;
}

Result<simulation::World> through_a_file(const std::string& yaml) {
  std::string name = (std::filesystem::temp_directory_path() / "cairn-world-XXXXXX").string();
  const int file = ::mkstemp(name.data());
  if (file < 0) return fail(name + ": cannot be made");
  ::close(file);
  std::ofstream(name) << yaml;
  auto world = simulation::load_world(name);
  std::filesystem::remove(name);
  return world;
}

class Architect {
 public:
  explicit Architect(unsigned seed) : random_{seed} {}

  std::string build() {
    lay_out();
    std::string body = "walls:\n" + walls() + "boxes:\n" + shell() + furniture();
    return head(body) + body + people(head(body) + body);
  }

 private:
  double between(double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 32>(random_);
  }
  int one_of(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

  void lay_out() {
    columns_ = 1 + one_of(3);
    rows_ = 1 + one_of(2);
    xs_ = {0};
    ys_ = {0};
    for (int i = 0; i < columns_; ++i) xs_.push_back(xs_.back() + between(2.8, 4.6));
    for (int i = 0; i < rows_; ++i) ys_.push_back(ys_.back() + between(2.8, 4.4));
  }

  // Of the walls between rooms all along one row of them have doors, and one in each column; of the
  // others every second. So every room can be reached.
  std::string walls() {
    std::string lines;
    const auto wall = [&](double x0, double y0, double x1, double y1, bool door) {
      lines +=
          text("  - {from_m: [%.3f, %.3f], to_m: [%.3f, %.3f], material: plaster", x0, y0, x1, y1);
      const double length = std::max(x1 - x0, y1 - y0);
      if (door) {
        const double at = between(0.75, length - 0.75);
        lines += text(", doors: [{at_m: %.3f, width_m: %.2f}]", at, kDoor_m);
        doors_.push_back({x1 > x0 ? x0 + at : x0, x1 > x0 ? y0 : y0 + at});
      }
      lines += "}\n";
    };
    wall(0, 0, xs_.back(), 0, false);
    wall(0, ys_.back(), xs_.back(), ys_.back(), false);
    wall(0, 0, 0, ys_.back(), false);
    wall(xs_.back(), 0, xs_.back(), ys_.back(), false);
    for (int i = 0; i < columns_; ++i) {
      for (int k = 0; k < rows_; ++k) {
        if (i > 0) wall(xs_[i], ys_[k], xs_[i], ys_[k + 1], k == 0 || one_of(2) == 0);
        if (k > 0) wall(xs_[i], ys_[k], xs_[i + 1], ys_[k], true);
      }
    }
    return lines;
  }

  std::string shell() {
    const double x = xs_.back();
    const double y = ys_.back();
    return text(
               "  - {name: floor, centre_m: [%.3f, %.3f, -0.1], size_m: [%.3f, %.3f, 0.2], "
               "material: stone}\n",
               x / 2, y / 2, x + 0.4, y + 0.4) +
           text(
               "  - {name: ceiling, centre_m: [%.3f, %.3f, 2.6], size_m: [%.3f, %.3f, 0.2], "
               "material: plaster}\n",
               x / 2, y / 2, x + 0.4, y + 0.4);
  }

  [[nodiscard]] bool keeps_ways_open(const Eigen::Vector2d& at, double radius) const {
    return std::all_of(doors_.begin(), doors_.end(), [&](const Eigen::Vector2d& door) {
      return (door - at).norm() > radius + 0.75;
    });
  }

  std::string furniture() {
    std::string lines;
    for (int i = 0; i < columns_; ++i) {
      for (int k = 0; k < rows_; ++k) {
        const int pieces = 2 + one_of(4);
        for (int n = 0; n < pieces; ++n) lines += piece(i, k);
      }
    }
    return lines;
  }

  std::string piece(int i, int k) {
    const double length = between(0.25, 1.3);
    const double width = between(0.25, 0.8);
    const double yaw_deg = one_of(2) == 0 ? 90.0 * one_of(4) : between(0, 360);
    const double radius = 0.5 * std::hypot(length, width);
    const Eigen::Vector2d at(between(xs_[i] + 0.2, xs_[i + 1] - 0.2),
                             between(ys_[k] + 0.2, ys_[k + 1] - 0.2));
    if (!keeps_ways_open(at, radius)) return "";
    // The robot's place is somewhere in the first room.
    if (i == 0 && k == 0 && (at - start()).norm() < radius + 0.5) return "";
    if (one_of(3) == 0) return table(at, length, width, yaw_deg);
    const double height = between(0.12, 1.6);
    return text(
        "  - {centre_m: [%.3f, %.3f, %.3f], size_m: [%.3f, %.3f, %.3f], rpy_deg: [0, 0, "
        "%.1f], material: wood}\n",
        at.x(), at.y(), height / 2, length, width, height, yaw_deg);
  }

  std::string table(const Eigen::Vector2d& at, double length, double width, double yaw_deg) {
    const double leg = between(0.03, 0.06);
    std::string lines = text(
        "  - {centre_m: [%.3f, %.3f, 0.72], size_m: [%.3f, %.3f, 0.04], rpy_deg: [0, 0, %.1f], "
        "material: wood}\n",
        at.x(), at.y(), length, width, yaw_deg);
    const Eigen::Rotation2Dd turned(yaw_deg * std::numbers::pi / 180);
    for (const double sx : {-0.5, 0.5}) {
      for (const double sy : {-0.5, 0.5}) {
        const Eigen::Vector2d foot =
            at + turned * Eigen::Vector2d(sx * (length - leg), sy * (width - leg));
        lines += text(
            "  - {centre_m: [%.3f, %.3f, 0.35], size_m: [%.3f, %.3f, 0.7], rpy_deg: [0, "
            "0, %.1f], material: wood}\n",
            foot.x(), foot.y(), leg, leg, yaw_deg);
      }
    }
    return lines;
  }

  [[nodiscard]] Eigen::Vector2d start() const { return {0.5 * xs_[1], 0.5 * ys_[1]}; }

  std::string head(const std::string&) {
    if (heading_deg_ < 0) heading_deg_ = between(0, 360);
    return text("start: {at_m: [%.3f, %.3f], heading_deg: %.1f}\n", start().x(), start().y(),
                heading_deg_) +
           "materials:\n  - {name: stone}\n  - {name: plaster, seed: 2}\n  - {name: wood, seed: "
           "3}\n";
  }

  // Somebody walks between places that are free, on straight ways that are.
  std::string people(const std::string& without) {
    const simulation::World world = through_a_file(without).value();
    simulation::Walker walker;
    walker.radius_m = 0.3;
    walker.height_m = 1.75;
    auto floor = simulation::ReachableFloor::flood(world, start(), walker);
    if (!floor || floor->cells().empty()) return "";
    std::string lines = "people:\n";
    for (int person = 0; person < 2; ++person) {
      std::vector<Eigen::Vector2d> round;
      for (int tries = 0; tries < 3000 && round.size() < 5; ++tries) {
        const auto& cell = floor->cells()[random_() % floor->cells().size()];
        const Eigen::Vector2d at = cell.middle_m.head<2>();
        if (!floor->has_room_at(at) || (at - start()).norm() < 1) continue;
        if (!round.empty() &&
            (!free_between(*floor, round.back(), at) || (round.back() - at).norm() < 0.8))
          continue;
        round.push_back(at);
      }
      if (round.size() < 2) return "";
      // There and back again.
      lines +=
          text("  - {name: number %d, speed_mps: %.2f, waypoints: [", person, between(0.5, 0.9));
      for (std::size_t i = 0; i < round.size(); ++i)
        lines += text("%s{at_m: [%.3f, %.3f]}", i > 0 ? ", " : "", round[i].x(), round[i].y());
      for (std::size_t i = round.size() - 1; i-- > 1;)
        lines += text(", {at_m: [%.3f, %.3f]}", round[i].x(), round[i].y());
      lines += "]}\n";
    }
    return lines;
  }

  static bool free_between(const simulation::ReachableFloor& floor, const Eigen::Vector2d& from,
                           const Eigen::Vector2d& to) {
    const int steps = static_cast<int>((to - from).norm() / 0.02) + 1;
    for (int i = 0; i <= steps; ++i) {
      if (!floor.has_room_at(from + static_cast<double>(i) / steps * (to - from))) return false;
    }
    return true;
  }

  std::mt19937 random_;
  int columns_ = 1;
  int rows_ = 1;
  std::vector<double> xs_;
  std::vector<double> ys_;
  std::vector<Eigen::Vector2d> doors_;
  double heading_deg_ = -1;
};

}  // namespace

std::string random_world_yaml(unsigned seed) { return Architect(seed).build(); }

Result<simulation::World> random_world(unsigned seed) {
  return through_a_file(random_world_yaml(seed));
}

}  // namespace cairn::testing
