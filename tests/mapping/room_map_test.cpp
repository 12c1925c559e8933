// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "evaluation/map_score.hpp"
#include "mapping/projective_integrator.hpp"
#include "mapping/ray_integrator.hpp"
#include "simulation/disparity_model.hpp"
#include "simulation/observable_surface.hpp"
#include "simulation/world.hpp"

namespace cairn::mapping {
namespace {

/// What a fast demo's robot sees as it drives round in the furnished room, with its true poses.
class RoomMap : public ::testing::Test {
 protected:
  static constexpr double kResolution_m = 0.04;
  static constexpr double kMaxRange_m = 4;

  void SetUp() override {
    const std::filesystem::path config = std::filesystem::path(CAIRN_SOURCE_DIR) / "config";
    world_ = simulation::load_world(config / "worlds" / "room.yaml").value();
    rig_ = camera::load_rig(config / "calibration" / "simulated-25cm.yaml").value();
    const auto eyes = simulation::DisparityModel::create(world_, *rig_, 1).value();
    const std::array<Eigen::Vector2d, 5> corners{
        {{-1, -1.1}, {1.5, -1}, {1.4, 1.1}, {-1, 1.1}, {-1, -1.1}}};
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      for (double share = 0; share < 1; share += 0.1) look_round(corners[i], corners[i + 1], share);
    }
    for (const auto& pose : path_) {
      images_.push_back(eyes.see(pose.T, pose.utime / 100'000, pose.utime, {}));
    }
  }

  void look_round(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double share) {
    const Eigen::Vector2d at = from + share * (to - from);
    for (int turn = 0; turn < 6; ++turn) {
      Isometry T_world_body = Isometry::Identity();
      T_world_body.linear() = rotation_from_rpy(0, 0, 2 * M_PI * (turn + share) / 6);
      T_world_body.translation() << at.x(), at.y(), 0;
      path_.push_back({static_cast<Utime>(100'000 * path_.size()), T_world_body});
    }
  }

  template <class SomeIntegrator>
  VoxelMap mapped() const {
    RayIntegratorConfig config;
    config.max_range_m = kMaxRange_m;
    SomeIntegrator integrator{config};
    VoxelMap map{kResolution_m};
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const Isometry T_map_camera = path_[i].T * images_[i].camera.T_body_camera;
      EXPECT_TRUE(integrator.integrate(images_[i], T_map_camera, map));
    }
    return map;
  }

  evaluation::MapScore score(const VoxelMap& map) const {
    const double nearest_m = rig_->left.fx_px * rig_->baseline_m() / 190;
    const evaluation::MapTruth truth{
        [this](const Eigen::Vector3d& point) { return world_.distance_m(point); },
        simulation::observable_surface(world_, *rig_, path_, {0.02, nearest_m, 3, 4}).value()};
    std::vector<Eigen::Vector3d> occupied;
    std::vector<Eigen::Vector3d> free;
    map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
      for_each_voxel(brick.known, [&](int voxel) {
        (brick.occupied.test(voxel) ? occupied : free)
            .push_back(map.centre_of(voxel_in(index, voxel)));
      });
    });
    return evaluation::score_map(truth, {map.resolution_m(), 0.05}, occupied, free);
  }

  simulation::World world_;
  std::optional<camera::RigCalibration> rig_;
  std::vector<evaluation::StampedPose> path_;
  std::vector<stereo::DisparityImage> images_;
};

void print(const std::string& name, const evaluation::MapScore& score) {
  std::cout << name << ": precision " << *score.precision << ", recall " << *score.recall
            << ", of the free space false " << *score.false_free_rate << "; "
            << score.occupied_voxels << " occupied, " << score.free_voxels << " free\n";
}

TEST_F(RoomMap, ProjectiveCarvingMapsItNoWorseThanExactRayWalkingAndErasesLess) {
  const evaluation::MapScore exact = score(mapped<RayIntegrator>());
  const evaluation::MapScore projective = score(mapped<ProjectiveIntegrator>());
  print("exact", exact);
  print("projective", projective);
  EXPECT_GT(*projective.precision, 0.96);
  EXPECT_GT(*projective.precision, *exact.precision - 0.003);
  EXPECT_GT(*projective.recall, *exact.recall);
  EXPECT_LT(*projective.false_free_rate, 0.5 * *exact.false_free_rate);
  EXPECT_GT(projective.free_voxels, 0.9 * static_cast<double>(exact.free_voxels));
}

/// For each class in one map, the shares that are unknown, free and occupied in another.
using Shares = std::array<std::array<double, 3>, 3>;

void count_from(const VoxelMap& from, const VoxelMap& to, std::array<std::array<double, 3>, 3>& n,
                bool also_counted) {
  from.grid().for_each([&](BrickIndex index, const EvidenceBrick&) {
    if (also_counted && to.grid().find(index) != nullptr) return;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const VoxelIndex voxel = voxel_in(index, i);
      const auto a = static_cast<std::size_t>(from.state(voxel).voxel_class);
      const auto b = static_cast<std::size_t>(to.state(voxel).voxel_class);
      ++(also_counted ? n[b][a] : n[a][b]);
    }
  });
}

Shares shares(const VoxelMap& of, const VoxelMap& in) {
  Shares counts{};
  count_from(of, in, counts, false);
  count_from(in, of, counts, true);
  for (std::size_t a : {0, 1, 2}) {
    const double all = counts[a][0] + counts[a][1] + counts[a][2];
    for (double& count : counts[a]) count /= all;
    std::cout << std::array{"unknown ", "free ", "occupied "}[a]
              << "by exact ray walking: " << 100 * counts[a][0] << " % unknown, "
              << 100 * counts[a][1] << " % free, " << 100 * counts[a][2]
              << " % occupied by projective carving\n";
  }
  return counts;
}

// They differ where projective carving is meant to: a shell before surfaces, at grazing angles the
// thicker, and the rim of the view stay unknown; surfaces that exact walking erases stay.
TEST_F(RoomMap, BothAgreeOnAlmostAllThatIsFreeAndAllThatIsOccupied) {
  const Shares of = shares(mapped<RayIntegrator>(), mapped<ProjectiveIntegrator>());
  constexpr std::size_t kUnknown = 0;
  constexpr std::size_t kFree = 1;
  constexpr std::size_t kOccupied = 2;
  EXPECT_GT(of[kFree][kFree], 0.9);
  EXPECT_LT(of[kFree][kOccupied], 0.03);
  EXPECT_GT(of[kOccupied][kOccupied], 0.95);
  EXPECT_LT(of[kOccupied][kFree], 0.03);
  EXPECT_LT(of[kUnknown][kFree], 0.05);
}

}  // namespace
}  // namespace cairn::mapping
