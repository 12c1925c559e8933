// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/config.hpp"
#include "localization/distance_field.hpp"
#include "localization/particle.hpp"
#include "localization/view.hpp"

namespace cairn::localization {

struct SensorConfig {
  int beams = 80;
  double map_sigma_m = 0.04;
  double outlier_share = 0.15;
  double unknown_likelihood = 0.4;
  double independent_beams = 10;

  void visit(ConfigVisitor& v) {
    v.integer("beams", beams, 10, 1000, "", "points of a frame that guesses are compared by");
    v.number("map_sigma_m", map_sigma_m, {0.005, 0.5}, "m",
             "how far the map is off, for a guess (one sigma)");
    v.number("outlier_share", outlier_share, {0.01, 0.9}, "",
             "share of points that may lie anywhere: people, new things, wrong matches");
    v.number("unknown_likelihood", unknown_likelihood, {0, 1}, "",
             "of a point that falls where the map knows nothing; 1: as good as a fit");
    v.number("independent_beams", independent_beams, {1, 200}, "",
             "how many points count as independent of each other; neighbours err alike");
  }
};

/// Scores guesses of the body's pose by what was seen from it, in units of the disparity's noise
/// (each beam has its own sigma, which grows with the square of its range, so that a pixel of
/// disparity counts the same near and far). Likelihood field (Thrun, Burgard and Fox 2005, table
/// 6.3) with a floor for outliers; tempered, for beams of one image are not independent.
class SensorModel {
 public:
  /// How far apart guesses lie: the truth may be as far from the nearest, so the model must not be
  /// finer than that.
  struct Spacing {
    double m = 0;
    double rad = 0;
  };

  /// Takes every so-many-th beam of the view, and turns it by the tilt that all guesses share.
  SensorModel(const SensorConfig& config, const View& view, const Eigen::Matrix3d& R_tilt,
              double cell_m, const Spacing& spacing);

  [[nodiscard]] std::size_t beams() const { return beams_.size(); }

  /// Natural logarithm of how likely the view is from there, tempered; by where the beams end.
  [[nodiscard]] double log_likelihood(const Particle& particle, DistanceField::Cursor& cells,
                                      const DistanceField& field) const;

  /// As log_likelihood, but a beam that would have to go through something on its way counts as an
  /// outlier: what the guess would see stands nearer.
  [[nodiscard]] double log_likelihood_along(const Particle& particle, DistanceField::Cursor& cells,
                                            const DistanceField& field) const;

  /// The mean likelihood of a beam that a log-likelihood stands for, 0 to 1.
  [[nodiscard]] double mean_likelihood(double log_likelihood) const;

 private:
  struct LevelBeam {
    Eigen::Vector3d end_m;  ///< from the body's origin, yaw taken out
    double range_m;         ///< from the camera
    double sigma_m;
    /// Natural logarithm of its likelihood, by the field's distance where it ends.
    std::array<float, DistanceField::kFar + 1> log_at;
  };
  struct Pose {
    double cos_yaw;
    double sin_yaw;
    Eigen::Vector3d at_m;
    [[nodiscard]] Eigen::Vector3d of(const Eigen::Vector3d& level) const {
      return {at_m.x() + cos_yaw * level.x() - sin_yaw * level.y(),
              at_m.y() + sin_yaw * level.x() + cos_yaw * level.y(), at_m.z() + level.z()};
    }
  };
  [[nodiscard]] static Pose placed(const Particle& particle);
  [[nodiscard]] float beam_log(const LevelBeam& beam, std::uint8_t distance) const;
  [[nodiscard]] bool blocked(const LevelBeam& beam, const Pose& pose, DistanceField::Cursor& cells,
                             const DistanceField& field) const;
  [[nodiscard]] double temper() const;

  SensorConfig config_;
  double cell_m_;
  float log_unknown_;
  float log_outlier_;
  Eigen::Vector3d eye_m_;  ///< from the body's origin, yaw taken out
  std::vector<LevelBeam> beams_;
};

}  // namespace cairn::localization
