// SPDX-License-Identifier: Apache-2.0
#include "simulation/observable_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "simulation/pixel_rays.hpp"
#include "simulation/ray_scene.hpp"

namespace cairn::simulation {
namespace {

/// A cell of a face, and the point in its middle.
struct Cell {
  std::uint64_t key;
  Eigen::Vector3d middle_m;
};

/// Middle of cell `index` along an edge of `size_m`; the last cell may be shorter.
double middle_m(int index, double spacing_m, double size_m) {
  return 0.5 * (index * spacing_m + std::min((index + 1) * spacing_m, size_m));
}

Cell cell_at(FaceIndex index, const Face& face, const Eigen::Vector3d& point_m, double spacing_m) {
  const auto cell = [&](const Eigen::Vector3d& axis, double size_m) {
    const double along_m = std::clamp(axis.dot(point_m - face.corner_m), 0.0, size_m);
    const int cells = std::max(1, static_cast<int>(std::ceil(size_m / spacing_m)));
    return std::min(static_cast<int>(along_m / spacing_m), cells - 1);
  };
  const int s = cell(face.axis_s, face.size_s_m);
  const int t = cell(face.axis_t, face.size_t_m);
  const std::uint64_t key = static_cast<std::uint64_t>(index) << 40 |
                            static_cast<std::uint64_t>(s) << 20 | static_cast<std::uint64_t>(t);
  return {key,
          face.at(middle_m(s, spacing_m, face.size_s_m), middle_m(t, spacing_m, face.size_t_m))};
}

/// Looks from pose to pose and keeps what both cameras see.
class Observer {
 public:
  Observer(const RayScene& scene, const camera::RigCalibration& rig,
           std::vector<Eigen::Vector3f> left_rays, const ObservableConfig& config)
      : scene_{scene}, rig_{rig}, config_{config} {
    for (int row = 0; row < rig.height_px; row += config.pixel_step) {
      for (int col = 0; col < rig.width_px; col += config.pixel_step) {
        rays_.push_back(left_rays[static_cast<std::size_t>(row * rig.width_px + col)]);
      }
    }
  }

  void look(const Isometry& T_world_body) {
    const Isometry T_world_left = T_world_body * rig_.T_body_left;
    const Isometry T_world_right = T_world_left * rig_.T_right_left.inverse();
    const Eigen::Vector3d left_m = T_world_left.translation();
    std::vector<Eigen::Vector3f> directions;
    directions.reserve(rays_.size());
    const Eigen::Matrix3f R = T_world_left.linear().cast<float>();
    for (const Eigen::Vector3f& ray : rays_) directions.emplace_back(R * ray);
    std::vector<FaceIndex> found(directions.size());
    scene_.first_faces(left_m.cast<float>(), directions, found);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i] == kNothing) continue;
      const Face& face = scene_.faces()[found[i]];
      const Eigen::Vector3d direction = directions[i].cast<double>();
      const double along = face.normal.dot(face.corner_m - left_m) / face.normal.dot(direction);
      const double range_m = along * direction.norm();
      if (!(range_m >= config_.min_range_m && range_m <= config_.max_range_m)) continue;
      const Cell cell = cell_at(found[i], face, left_m + along * direction, config_.spacing_m);
      if (seen_.contains(cell.key) || !scene_.sees(left_m, cell.middle_m) ||
          !right_sees(T_world_right, cell.middle_m)) {
        continue;
      }
      seen_.insert(cell.key);
      points_m_.push_back(cell.middle_m);
    }
  }

  [[nodiscard]] std::vector<Eigen::Vector3d> take() { return std::move(points_m_); }

 private:
  [[nodiscard]] bool right_sees(const Isometry& T_world_right,
                                const Eigen::Vector3d& point_m) const {
    const auto pixel = project(rig_.right, T_world_right.inverse() * point_m);
    return pixel && pixel->x() >= 0 && pixel->x() <= rig_.width_px - 1 && pixel->y() >= 0 &&
           pixel->y() <= rig_.height_px - 1 && scene_.sees(T_world_right.translation(), point_m);
  }

  const RayScene& scene_;
  const camera::RigCalibration& rig_;
  ObservableConfig config_;
  std::vector<Eigen::Vector3f> rays_;
  std::unordered_set<std::uint64_t> seen_;
  std::vector<Eigen::Vector3d> points_m_;
};

}  // namespace

Result<std::vector<Eigen::Vector3d>> observable_surface(
    const World& world, const camera::RigCalibration& rig,
    std::span<const evaluation::StampedPose> path, const ObservableConfig& config) {
  if (const auto ok = camera::check(rig); !ok) return tl::make_unexpected(ok.error());
  auto rays = pixel_rays(rig.left, rig.width_px, rig.height_px);
  if (!rays) return fail("left " + rays.error().message);
  const auto scene = RayScene::create(world.boxes);
  if (!scene) return tl::make_unexpected(scene.error());
  Observer observer(*scene, rig, std::move(*rays), config);
  for (const evaluation::StampedPose& pose : path) observer.look(pose.T);
  return observer.take();
}

}  // namespace cairn::simulation
