// SPDX-License-Identifier: Apache-2.0
#include "localization/particle_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "rendered_map.hpp"

namespace cairn::localization {
namespace {

using testing::on_floor;

constexpr double kDegree = std::numbers::pi / 180;

/// A room of config/worlds, mapped from true poses that half a turn maps onto each other.
struct MappedRoom {
  explicit MappedRoom(const std::string& name)
      : world{testing::world_named(name)}, eyes{world, 0.3, 5}, map{0.02} {
    for (const auto& [x, y] : {std::pair{-1.2, -1.0}, {1.2, 1.0}, {-1.0, 1.0}, {1.0, -1.0}}) {
      for (int i = 0; i < 12; ++i) {
        const Isometry T = on_floor(x, y, 30 * i * kDegree);
        map.see(eyes.look(T, ++now), T);
      }
    }
    map.tell(now);
    fielded.take_all(map.replica);
  }

  View view_from(const Isometry& T) { return make_view(eyes.look(T, ++now), {}, 1); }

  simulation::World world;
  testing::NoisyEyes eyes;
  testing::OwnMap map;
  testing::Fielded fielded;
  Utime now = 0;
};

Motion turn(double angle_rad, double sigma_rad) {
  Motion motion;
  motion.T_from_to = on_floor(0, 0, angle_rad);
  motion.covariance.diagonal() << 1e-6, 1e-6, 1e-8, 1e-8, 1e-8, sigma_rad * sigma_rad;
  return motion;
}

double distance_m(const Isometry& a, const Isometry& b) {
  return (a.translation() - b.translation()).head<2>().norm();
}

double turned_rad(const Isometry& a, const Isometry& b) {
  return std::abs(std::remainder(yaw_rad(a) - yaw_rad(b), 2 * std::numbers::pi));
}

TEST(ParticleFilter, MovesWithTheMomentsOfItsMotion) {
  FilterConfig config;
  config.min_particles = 20'000;
  ParticleFilter filter(config, 1);
  PoseBelief start;
  start.T_map_body = on_floor(1, 2, 30 * kDegree);
  filter.start_at(start);
  Motion motion;
  motion.T_from_to = on_floor(0.5, 0.1, 10 * kDegree);
  motion.covariance.diagonal() << 0.04, 0.01, 0.0001, 0, 0, 0.0025;
  motion.covariance(0, 5) = motion.covariance(5, 0) = 0.006;
  const Isometry expected = start.T_map_body * motion.T_from_to;
  filter.move(motion, expected);
  const auto count = static_cast<double>(filter.particles().size());
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  for (const Particle& p : filter.particles()) {
    // In the axes of the body after the motion, in which the covariance is given.
    Eigen::Vector3d off = expected.inverse() * Eigen::Vector3d(p.x_m, p.y_m, p.z_m);
    const Eigen::Vector4d error(off.x(), off.y(), off.z(), p.yaw_rad - yaw_rad(expected));
    mean += error / count;
    covariance += error * error.transpose() / count;
  }
  EXPECT_LT(mean.norm(), 0.006);
  EXPECT_NEAR(covariance(0, 0), 0.04, 0.0015);
  EXPECT_NEAR(covariance(1, 1), 0.01, 0.0004);
  EXPECT_NEAR(covariance(2, 2), 0.0001, 0.000004);
  EXPECT_NEAR(covariance(3, 3), 0.0025, 0.0001);
  EXPECT_NEAR(covariance(0, 3), 0.006, 0.0004);
}

TEST(ParticleFilter, TheTruePlaceIsMoreLikelyThanThoseAround) {
  MappedRoom room("room");
  for (int i = 0; i < 12; ++i) {
    const Isometry T = on_floor(0.9, 0.6, 30 * i * kDegree);
    const View view = room.view_from(T);
    const SensorModel model({}, view, Eigen::Matrix3d::Identity(), room.fielded.field.cell_m(), {});
    DistanceField::Cursor cells(room.fielded.field);
    const auto log_at = [&](double dx, double dy, double dyaw) {
      const Particle particle{0.9 + dx, 0.6 + dy, 0, 30 * i * kDegree + dyaw, 1};
      return model.log_likelihood_along(particle, cells, room.fielded.field);
    };
    const double here = log_at(0, 0, 0);
    EXPECT_GT(here, log_at(0, 0, 15 * kDegree)) << i;
    EXPECT_GT(here, log_at(0, 0, -15 * kDegree)) << i;
    EXPECT_GT(here, std::max(log_at(0.5, 0, 0), log_at(0, 0.5, 0))) << i;
    EXPECT_GT(here, std::max(log_at(-0.5, 0, 0), log_at(0, -0.5, 0))) << i;
  }
}

// From nowhere, by turning on the spot.
void expect_found(const std::string& resampling, std::uint64_t seed) {
  MappedRoom room("room");
  FilterConfig config;
  config.resampling = resampling;
  ParticleFilter filter(config, seed);
  double heading = 40 * kDegree;
  ASSERT_TRUE(filter.start_anywhere(room.fielded.field, on_floor(0, 0, 0)));
  Isometry T;
  for (int i = 0; i < 60; ++i) {
    T = on_floor(-0.8, 0.9, heading);
    (void)filter.weigh(room.fielded.field, room.view_from(T));
    if (i == 59) break;
    heading += 6 * kDegree;
    filter.move(turn(6 * kDegree, 0.5 * kDegree), T);
  }
  const auto clusters = filter.clusters();
  ASSERT_FALSE(clusters.empty());
  EXPECT_GT(clusters.front().weight, 0.5);
  // Near enough for the refinement to do the rest.
  EXPECT_LT(distance_m(clusters.front().pose.T_map_body, T), RefinementConfig{}.reach_m);
  EXPECT_LT(turned_rad(clusters.front().pose.T_map_body, T), 6 * kDegree);
}

TEST(ParticleFilter, FindsItselfFromNowhereByTurning) {
  for (const std::uint64_t seed : {1, 2, 3}) expect_found("systematic", seed);
}

TEST(ParticleFilter, FindsItselfByCoarseRandomSortingToo) {
  for (const std::uint64_t seed : {1, 2, 3}) expect_found("coarse", seed);
}

// The paper's figure 4: in a room that is the same after half a turn, two places stay.
TEST(ParticleFilter, InASymmetricRoomTwoPlacesStay) {
  MappedRoom room("symmetric-room");
  ParticleFilter filter({}, 4);
  ASSERT_TRUE(filter.start_anywhere(room.fielded.field, on_floor(0, 0, 0)));
  Isometry T;
  double heading = 20 * kDegree;
  for (int i = 0; i < 40; ++i) {
    T = on_floor(0.7, 0.5, heading);
    (void)filter.weigh(room.fielded.field, room.view_from(T));
    if (i == 39) break;
    heading += 6 * kDegree;
    filter.move(turn(6 * kDegree, 0.5 * kDegree), T);
  }
  const Isometry other = on_floor(0, 0, std::numbers::pi) * T;
  double here = 0;
  double there = 0;
  for (const Cluster& cluster : filter.clusters()) {
    if (distance_m(cluster.pose.T_map_body, T) < 0.3) here += cluster.weight;
    if (distance_m(cluster.pose.T_map_body, other) < 0.3) there += cluster.weight;
  }
  EXPECT_GT(here, 0.05);
  EXPECT_GT(there, 0.05);
  EXPECT_GT(here + there, 0.8);
}

// Carried away while it was sure: the fit falls, strangers come in, and the right place wins.
TEST(ParticleFilter, AFalseLockIsUndone) {
  MappedRoom room("room");
  ParticleFilter filter({}, 6);
  PoseBelief start;
  start.T_map_body = on_floor(-1.2, -1.1, 0);
  start.covariance.diagonal() << 1e-4, 1e-4, 1e-6, 1e-6, 1e-6, 1e-4;
  filter.start_at(start);
  const View before = room.view_from(start.T_map_body);
  for (int i = 0; i < 30; ++i) {
    filter.move(turn(0, 0.2 * kDegree), start.T_map_body);
    (void)filter.weigh(room.fielded.field, before);
  }
  Isometry T;
  double heading = 100 * kDegree;
  double right = 0;
  for (int i = 0; i < 200 && right < 0.5; ++i) {
    T = on_floor(1.1, 0.9, heading);
    (void)filter.weigh(room.fielded.field, room.view_from(T));
    right = 0;
    for (const Cluster& cluster : filter.clusters()) {
      if (distance_m(cluster.pose.T_map_body, T) < 0.2) right += cluster.weight;
    }
    heading += 4 * kDegree;
    filter.move(turn(4 * kDegree, 0.5 * kDegree), on_floor(0, 0, heading));
  }
  EXPECT_GE(right, 0.5);
}

TEST(ParticleFilter, TheSameCallsGiveTheSameParticles) {
  MappedRoom room("room");
  const Isometry T = on_floor(0.5, 0.5, 1);
  const View view = room.view_from(T);
  const auto run = [&](std::uint64_t seed) {
    ParticleFilter filter({}, seed);
    EXPECT_TRUE(filter.start_anywhere(room.fielded.field, T));
    for (int i = 0; i < 5; ++i) {
      (void)filter.weigh(room.fielded.field, view);
      filter.move(turn(0.01, 0.01), T);
    }
    return std::vector<Particle>(filter.particles().begin(), filter.particles().end());
  };
  const auto same = [](const Particle& a, const Particle& b) {
    return a.x_m == b.x_m && a.y_m == b.y_m && a.yaw_rad == b.yaw_rad && a.weight == b.weight;
  };
  const auto one = run(9);
  const auto two = run(9);
  EXPECT_TRUE(std::equal(one.begin(), one.end(), two.begin(), two.end(), same));
  const auto other = run(10);
  EXPECT_FALSE(std::equal(one.begin(), one.end(), other.begin(), other.end(), same));
}

TEST(ParticleFilter, AnEmptyMapOffersNoPlaceAndTeachesNothing) {
  ParticleFilter filter({}, 1);
  const DistanceField nothing;
  EXPECT_FALSE(filter.start_anywhere(nothing, Isometry::Identity()));
  filter.start_at({});
  View view;
  view.beams.resize(100);
  (void)filter.weigh(nothing, view);
  for (const Particle& particle : filter.particles()) {
    EXPECT_TRUE(std::isfinite(particle.x_m) && std::isfinite(particle.weight));
  }
}

}  // namespace
}  // namespace cairn::localization
