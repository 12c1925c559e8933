// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/simulated_place.hpp"

#include <numbers>

#include "camera/rig_calibration.hpp"
#include "evaluation/map_score.hpp"
#include "simulation/floor_sight.hpp"
#include "simulation/observable_surface.hpp"
#include "simulation/playground.hpp"

namespace cairn::cli {
namespace {

// Between poses that are nearer to each other than this nothing new comes into view.
constexpr double kLookEvery_m = 0.1;
constexpr double kLookEvery_rad = 0.1;

evaluation::Trajectory thinned(const evaluation::Trajectory& path) {
  evaluation::Trajectory kept;
  for (const evaluation::StampedPose& pose : path) {
    if (!kept.empty()) {
      const Isometry step = kept.back().T.inverse() * pose.T;
      if (step.translation().norm() < kLookEvery_m &&
          Eigen::AngleAxisd(step.linear()).angle() < kLookEvery_rad) {
        continue;
      }
    }
    kept.push_back(pose);
  }
  return kept;
}

bool is_free(const mapping::EvidenceBrick& brick) {
  return !brick.occupied.any() && brick.known.count() == mapping::kBrickVoxels;
}

void add(const mapping::VoxelMap& map, const Isometry& T_world_map,
         const evaluation::DistanceFunction& distance_m, evaluation::MapScorer& scorer) {
  const double size_m = map.resolution_m();
  const double side_m = mapping::kBrickSide * size_m;
  map.grid().for_each([&](mapping::BrickIndex index, const mapping::EvidenceBrick& brick) {
    const Eigen::Vector3d middle_m =
        T_world_map * (map.centre_of(mapping::voxel_in(index, 0)) +
                       Eigen::Vector3d::Constant(0.5 * (side_m - size_m)));
    // Free space far from everything is counted by bricks: there is a lot of it.
    if (is_free(brick) && distance_m(middle_m) > std::numbers::sqrt3 * side_m) {
      return scorer.add_free({middle_m, side_m});
    }
    mapping::for_each_voxel(brick.known, [&](int voxel) {
      const evaluation::Voxel cube{T_world_map * map.centre_of(mapping::voxel_in(index, voxel)),
                                   size_m};
      if (brick.occupied.test(voxel)) {
        scorer.add_occupied(cube);
      } else {
        scorer.add_free(cube);
      }
    });
  });
}

}  // namespace

struct SimulatedPlace::State {
  simulation::World world;
  camera::RigCalibration rig;
  simulation::FloorSight sight;
  double nearest_m;
};

Result<SimulatedPlace> SimulatedPlace::load(const SimulatorConfig& config,
                                            double max_disparity_px) {
  auto world = simulation::load_world(config.world);
  if (!world) return tl::make_unexpected(world.error());
  const auto playground = simulation::Playground::create(
      std::make_shared<const simulation::World>(*world), config.robot, config.tracks,
      static_cast<std::size_t>(config.people), 0);
  if (!playground) return fail(config.world + ": " + playground.error().message);
  auto rig = camera::load_rig(config.rig);
  if (!rig) return tl::make_unexpected(rig.error());
  simulation::Walker walker;
  walker.radius_m = config.robot.turning_radius_m();
  walker.height_m = config.robot.height_m;
  auto floor = simulation::ReachableFloor::flood(
      *world, world->T_world_start.translation().head<2>(), walker);
  if (!floor) return fail(config.world + ": start: " + floor.error().message);
  auto sight = simulation::FloorSight::create(*world, *rig, config.robot, std::move(*floor), {});
  if (!sight) return fail(config.world + ": " + sight.error().message);
  const double nearest_m = rig->left.fx_px * rig->baseline_m() / max_disparity_px;
  return SimulatedPlace(std::make_unique<State>(
      State{std::move(*world), std::move(*rig), std::move(*sight), nearest_m}));
}

SimulatedPlace::SimulatedPlace(std::unique_ptr<State> state) : state_{std::move(state)} {}
SimulatedPlace::~SimulatedPlace() = default;
SimulatedPlace::SimulatedPlace(SimulatedPlace&&) noexcept = default;

void SimulatedPlace::visit(const Isometry& T_world_body) { state_->sight.look(T_world_body); }

double SimulatedPlace::coverage() const { return state_->sight.share(); }

Result<evaluation::MapReport> SimulatedPlace::score(
    const mapping::VoxelMap& map, const Isometry& T_world_map,
    const evaluation::Trajectory& T_world_body) const {
  simulation::ObservableConfig observable;
  observable.min_range_m = state_->nearest_m;
  auto surface =
      simulation::observable_surface(state_->world, state_->rig, thinned(T_world_body), observable);
  if (!surface) return tl::make_unexpected(surface.error());
  const evaluation::MapTruth truth{
      [this](const Eigen::Vector3d& point) { return state_->world.distance_m(point); },
      std::move(*surface)};
  evaluation::MapScorer scorer(truth, {map.resolution_m(), kTolerance_m});
  add(map, T_world_map, truth.distance_m, scorer);
  const evaluation::MapScore score = scorer.score();
  evaluation::MapReport report;
  report.tolerance_m = score.tolerance_m;
  report.precision = score.precision;
  report.recall = score.recall;
  report.iou = score.iou;
  report.false_free_rate = score.false_free_rate;
  return report;
}

}  // namespace cairn::cli
