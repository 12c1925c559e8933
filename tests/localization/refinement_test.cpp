// SPDX-License-Identifier: Apache-2.0
#include "localization/refinement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <chrono>
#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

#include "rendered_map.hpp"

namespace cairn::localization {
namespace {

using testing::on_floor;

constexpr double kDegree = std::numbers::pi / 180;

struct Place {
  double x_m;
  double y_m;
};

/// Turned round once at each of these places, with true poses.
void map_from(testing::NoisyEyes& eyes, testing::OwnMap& map, const std::vector<Place>& places) {
  Utime now = 0;
  for (const Place& place : places) {
    for (int i = 0; i < 36; ++i) {
      const Isometry T = on_floor(place.x_m, place.y_m, i * 10 * kDegree);
      map.see(eyes.look(T, ++now), T);
    }
  }
  map.tell(now);
}

struct Spread {
  double worst_m = 0;
  double worst_rad = 0;
  double mean_m = 0;
  int bad = 0;
  int count = 0;
  double ms = 0;
};

Spread refine_from_all_sides(testing::NoisyEyes& eyes, const MapView& map,
                             const std::vector<Place>& places, double off_m, double off_rad) {
  Spread spread;
  Utime now = 1'000'000;
  for (const Place& place : places) {
    for (int i = 0; i < 12; ++i) {
      const Isometry T = on_floor(place.x_m, place.y_m, (i * 30 + 7) * kDegree);
      const View view = make_view(eyes.look(T, ++now), {}, 1);
      const double direction = i * 1.3;
      const Isometry start =
          on_floor(place.x_m + off_m * std::cos(direction), place.y_m + off_m * std::sin(direction),
                   (i * 30 + 7) * kDegree + (i % 2 == 0 ? off_rad : -off_rad));
      const auto began = std::chrono::steady_clock::now();
      PoseBelief known;
      known.T_map_body = start;
      known.covariance.diagonal() << 0.04, 0.04, 4e-4, 4e-4, 4e-4, 0.04;
      const Refinement refined = refine(map, view, known, {});
      spread.ms +=
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began)
              .count();
      const Vector6d error = change_between(T, refined.pose.T_map_body);
      spread.worst_m = std::max(spread.worst_m, error.head<3>().norm());
      spread.worst_rad = std::max(spread.worst_rad, error.tail<3>().norm());
      spread.mean_m += error.head<3>().norm();
      spread.bad += error.head<3>().norm() > 0.01 || error.tail<3>().norm() > 0.3 * kDegree ? 1 : 0;
      ++spread.count;
      if (std::getenv("CAIRN_SHOW") != nullptr)
        std::cout << place.x_m << " " << place.y_m << " " << i * 30 + 7 << ": " << error.transpose()
                  << " dirs " << refined.directions << " points " << refined.points << "/"
                  << view.beams.size() << " cost " << refined.before.cost << " -> "
                  << refined.after.cost << (refined.improved ? "" : " NOT") << "\n";
      if (std::getenv("CAIRN_EIG") != nullptr) {
        Vector6d L;
        L << 1, 1, 1, 2, 2, 2;
        const Matrix6d Hs = L.cwiseInverse().asDiagonal() * refined.pose.covariance.inverse() *
                            L.cwiseInverse().asDiagonal();
        Eigen::SelfAdjointEigenSolver<Matrix6d> es(Hs);
        for (int k = 0; k < 6; ++k) {
          const double e = es.eigenvectors().col(k).dot(error.cwiseProduct(L));
          std::cout << "EIG " << 1 / std::sqrt(std::max(es.eigenvalues()[k], 1e-9)) << " " << e
                    << " " << refined.pose.covariance.inverse().trace() << "\n";
        }
      }
    }
  }
  spread.mean_m /= spread.count;
  spread.ms /= spread.count;
  return spread;
}

void try_world(const std::string& name, double resolution_m, double noise_px,
               const std::vector<Place>& from, const std::vector<Place>& at) {
  const simulation::World world = testing::world_named(name);
  testing::NoisyEyes eyes(world, noise_px, 5);
  testing::OwnMap own(resolution_m);
  map_from(eyes, own, from);
  testing::Fielded fielded;
  fielded.take_all(own.replica);
  const MapView map{own.replica, fielded.field, fielded.surfaces};
  for (const auto& [off_m, off_deg] : {std::pair{0.0, 0.0}, {0.03, 1.0}, {0.10, 5.0}}) {
    const Spread s = refine_from_all_sides(eyes, map, at, off_m, off_deg * kDegree);
    std::cout << name << " " << resolution_m << " m, noise " << noise_px << " px, from " << off_m
              << " m " << off_deg << " deg: bad " << s.bad << "/" << s.count << " worst "
              << s.worst_m * 1e3 << " mm " << s.worst_rad / kDegree << " deg mean "
              << s.mean_m * 1e3 << " mm, " << s.ms << " ms\n";
  }
}

TEST(Refinement, Trial) {
  for (const double noise_px : {0.0, 0.3}) {
    for (const double resolution_m : {0.02, 0.01}) {
      try_world("room", resolution_m, noise_px, {{-1.2, -1.1}, {1, 0.8}, {-1, 1}, {1.2, -0.9}},
                {{-0.9, -0.8}, {0.8, 1.0}, {-0.5, 0.9}, {1.0, -0.7}});
    }
  }
}

}  // namespace
}  // namespace cairn::localization
