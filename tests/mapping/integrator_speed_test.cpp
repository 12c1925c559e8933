// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <limits>
#include <string>

#include "mapping/made_images.hpp"
#include "mapping/projective_integrator.hpp"
#include "mapping/ray_integrator.hpp"
#include "mapping/thread_time.hpp"

namespace cairn::mapping {
namespace {

/// Drives forward through the same view and prints what a frame costs.
template <class SomeIntegrator>
void report(const std::string& name, const stereo::DisparityImage& image, double resolution_m,
            double max_range_m, double step_m) {
  constexpr int kFrames = 10;
  RayIntegratorConfig config;
  config.max_range_m = max_range_m;
  SomeIntegrator integrator{config};
  VoxelMap map{resolution_m};
  double total_ms = 0;
  double least_ms = std::numeric_limits<double>::infinity();
  Integration last;
  for (int frame = 0; frame < kFrames; ++frame) {
    Isometry T_map_camera = Isometry::Identity();
    T_map_camera.linear() = R_body_camera_forward();
    T_map_camera.translation() = Eigen::Vector3d{frame * step_m, 0, 1.1};
    const double before_ms = testing::thread_ms();
    last = integrator.integrate(image, T_map_camera, map).value();
    const double taken_ms = testing::thread_ms() - before_ms;
    total_ms += taken_ms;
    least_ms = std::min(least_ms, taken_ms);
  }
  EXPECT_GT(last.hits, 0u);
  std::cout << name << ": " << last.rays << " rays, " << last.voxels << " voxels, mean "
            << total_ms / kFrames << " ms, least " << least_ms << " ms a frame; map "
            << static_cast<double>(map.bytes()) / 1e6 << " MB\n";
}

/// A ground below and a wall on either side, seen by a level camera.
stereo::DisparityImage street(const stereo::RectifiedCamera& camera, int step_px, double height_m,
                              double wall_m, double far_m) {
  return testing::image_of(camera, step_px, [&](int row, int col) {
    const double x = std::abs(col * step_px - camera.cx_px) / camera.f_px;
    const double y = (row * step_px - camera.cy_px) / camera.f_px;
    return std::min({far_m, wall_m / std::max(x, 1e-9), y > 0 ? height_m / y : far_m});
  });
}

template <class SomeIntegrator>
void report_all() {
  stereo::RectifiedCamera wide;
  wide.f_px = 707;
  wide.cx_px = 601.9;
  wide.cy_px = 183.1;
  wide.baseline_m = 0.537;
  wide.width_px = 1226;
  wide.height_px = 370;
  report<SomeIntegrator>("street, 0.2 m voxels, 30 m", street(wide, 2, 1.65, 7.3, 35), 0.2, 30,
                         0.8);
  const stereo::RectifiedCamera room = testing::small_camera(640, 480);
  const stereo::DisparityImage corridor = street(room, 2, 0.6, 1.1, 3.5);
  report<SomeIntegrator>("corridor, 1 cm voxels, 3 m", corridor, 0.01, 3, 0.02);
  report<SomeIntegrator>("corridor, 2 cm voxels, 3 m", corridor, 0.02, 3, 0.02);
  report<SomeIntegrator>("corridor, 4 cm voxels, 4 m", corridor, 0.04, 4, 0.02);
}

TEST(IntegratorSpeed, PrintsWhatAFrameCostsByExactRayWalking) { report_all<RayIntegrator>(); }

TEST(IntegratorSpeed, PrintsWhatAFrameCostsByProjectiveCarving) {
  report_all<ProjectiveIntegrator>();
}

}  // namespace
}  // namespace cairn::mapping
