// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/map_against_world.hpp"

#include "evaluation/map_score.hpp"
#include "simulation/observable_surface.hpp"
#include "stereo/matcher.hpp"

namespace cairn::cli {
namespace {

constexpr double kTolerance_m = 0.05;

}  // namespace

ScoreMap map_against_world(const simulation::World& world, const camera::RigCalibration& rig,
                           const evaluation::Trajectory& T_world_body) {
  return
      [&world, &rig, T_world_body](const mapping::VoxelMap& map,
                                   const Isometry& T_truth_map) -> Result<evaluation::MapReport> {
        simulation::ObservableConfig observable;
        observable.min_range_m =
            rig.left.fx_px * rig.baseline_m() / stereo::MatcherConfig{}.max_disparity_px;
        auto surface = simulation::observable_surface(world, rig, T_world_body, observable);
        if (!surface) return tl::make_unexpected(surface.error());
        const evaluation::MapTruth truth{
            [&world](const Eigen::Vector3d& point) { return world.distance_m(point); },
            std::move(*surface)};
        const double size_m = map.resolution_m();
        evaluation::MapScorer scorer(truth, {size_m, kTolerance_m});
        // The truth of a run is given in the frame of its first true pose.
        const Isometry T_world_map = T_world_body.front().T * T_truth_map;
        map.grid().for_each([&](mapping::BrickIndex index, const mapping::EvidenceBrick& brick) {
          mapping::for_each_voxel(brick.known, [&](int voxel) {
            const evaluation::Voxel cube{
                T_world_map * map.centre_of(mapping::voxel_in(index, voxel)), size_m};
            if (brick.occupied.test(voxel)) {
              scorer.add_occupied(cube);
            } else {
              scorer.add_free(cube);
            }
          });
        });
        const evaluation::MapScore score = scorer.score();
        evaluation::MapReport report;
        report.tolerance_m = score.tolerance_m;
        report.precision = score.precision;
        report.recall = score.recall;
        report.iou = score.iou;
        report.false_free_rate = score.false_free_rate;
        return report;
      };
}

}  // namespace cairn::cli
