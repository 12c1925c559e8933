// SPDX-License-Identifier: Apache-2.0
#include "self_mapped_drive.hpp"

#include <cmath>
#include <ctime>
#include <memory>
#include <random>

#include "core/robot.hpp"
#include "odometry/track_kinematics.hpp"
#include "simulation/drive_path.hpp"

namespace cairn::testing {
namespace {

using localization::Motion;

constexpr std::int64_t kFrame_us = 66'667;
constexpr std::size_t kFramesPerDelta = 4;
constexpr std::size_t kStanding_frames = 30;

}  // namespace

OdometryStep stereo_like(double drift, unsigned seed) {
  return [drift, random = std::mt19937{seed}](const Isometry& T_from_to) mutable {
    constexpr double kStep_m = 0.0005;
    constexpr double kStep_rad = 0.0003;
    std::normal_distribution<double> normal(0, 1);
    Motion said;
    const double way = T_from_to.translation().norm();
    const double turn = yaw_rad(T_from_to);
    const bool moves = way > 1e-6 || std::abs(turn) > 1e-6;
    Isometry error = Isometry::Identity();
    if (moves) {
      error.translation() =
          kStep_m * Eigen::Vector3d(normal(random), normal(random), normal(random) / 2);
      error.linear() = exp_so3(
          kStep_rad * Eigen::Vector3d(normal(random) / 3, normal(random) / 3, normal(random)));
    }
    Isometry biased = T_from_to;
    biased.translation() *= 1 + drift;
    biased.linear() = exp_so3({0, 0, turn * (1 + drift) + drift * way});
    said.T_from_to = biased * error;
    said.covariance.diagonal() << 1, 1, 0.25, 0.09, 0.09, 1;
    said.covariance.diagonal().head<3>() *= kStep_m * kStep_m;
    said.covariance.diagonal().tail<3>() *= kStep_rad * kStep_rad;
    return said;
  };
}

OdometryStep slipping_tracks(double slip) {
  return [slip](const Isometry& T_from_to) {
    const double gauge_m = RobotConfig{}.track_gauge_m;
    const double turn = yaw_rad(T_from_to);
    const double chord = T_from_to.translation().x() < 0 ? -T_from_to.translation().norm()
                                                         : T_from_to.translation().norm();
    const double arc = std::abs(turn) < 1e-9 ? chord : chord * (turn / 2) / std::sin(turn / 2);
    const odometry::TrackWay said{arc - turn * gauge_m / 2,
                                  (arc + turn * gauge_m / 2) / (1 - slip)};
    Motion motion;
    motion.T_from_to = odometry::in_space(odometry::track_motion(said, gauge_m));
    motion.covariance =
        odometry::track_covariance(said, gauge_m, odometry::TrackConfig{}.slip_sigma);
    return motion;
  };
}

double DriveResult::rms_m(const std::vector<Isometry>& a, const std::vector<Isometry>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (a[i].translation() - b[i].translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double DriveResult::end_m(const std::vector<Isometry>& a, const std::vector<Isometry>& b) {
  return (a.back().translation() - b.back().translation()).norm();
}

std::vector<Isometry> room_tour(int laps, double speed_mps) {
  simulation::DriveConfig config;
  config.speed_mps = speed_mps;
  const auto waypoints = simulation::room_tour_m();
  const auto lap = simulation::drive_round(waypoints, config);
  std::vector<Isometry> path(kStanding_frames, lap.front().T);
  for (int i = 0; i < laps; ++i) {
    for (const auto& pose : lap) path.push_back(pose.T);
  }
  return path;
}

DriveResult drive_and_map(const simulation::World& world, const std::vector<Isometry>& path,
                          const OdometryStep& odometry, double resolution_m, double noise_px,
                          unsigned seed, const localization::LocalizerConfig& config) {
  NoisyEyes eyes(world, noise_px, seed);
  OwnMap own(resolution_m);
  localization::Localizer localizer(config);
  DriveResult result;
  Isometry T_odom_body = Isometry::Identity();
  std::deque<std::function<void()>> deltas;
  mapping::MapReplica reader;
  std::deque<std::pair<std::size_t, mapping::MapDelta>> on_the_way;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Utime utime = 1'000'000 + static_cast<Utime>(k) * kFrame_us;
    localization::OdometryFrame frame;
    frame.utime = utime;
    if (k > 0) {
      const Motion said = odometry(path[k - 1].inverse() * path[k]);
      T_odom_body = T_odom_body * said.T_from_to;
      frame.step_covariance = said.covariance;
    }
    frame.T_odom_body = T_odom_body;
    const auto pose = localizer.move(frame);
    const Isometry T_map_body = pose.T_map_odom * T_odom_body;
    result.truth.push_back(path.front().inverse() * path[k]);
    result.odometry.push_back(T_odom_body);
    result.poses.push_back(T_map_body);
    result.published.push_back(pose);

    const auto image = eyes.look(path[k], utime);
    while (!on_the_way.empty() && on_the_way.front().first + 8 <= k) {
      (void)reader.apply(on_the_way.front().second).value();
      on_the_way.pop_front();
    }
    const std::clock_t began = std::clock();
    const auto update = localizer.update(image, reader, reader.take_changes());
    result.update_ms.push_back(1e3 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
    result.late += update.in_time ? 0 : 1;
    if (pose.certainty == localization::Certainty::kTracking) own.see(image, T_map_body);
    if (k % kFramesPerDelta == kFramesPerDelta - 1) on_the_way.emplace_back(k, own.delta(utime));
  }
  return result;
}

}  // namespace cairn::testing
