// SPDX-License-Identifier: Apache-2.0
#include "localization/sensor_model.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::localization {
namespace {

/// Nearer than this to the camera nothing blocks a beam: the robot itself is there.
constexpr double kBlind_m = 0.3;
/// Something stands before a beam's end if it is nearer by this and three sigmas.
constexpr double kBefore_m = 0.2;

}  // namespace

SensorModel::SensorModel(const SensorConfig& config, const View& view,
                         const Eigen::Matrix3d& R_tilt, double cell_m, const Spacing& spacing)
    : config_{config},
      cell_m_{cell_m},
      log_unknown_{static_cast<float>(
          std::log(config.outlier_share + (1 - config.outlier_share) * config.unknown_likelihood))},
      log_outlier_{static_cast<float>(std::log(config.outlier_share))},
      eye_m_{R_tilt * view.eye_m} {
  const std::size_t all = view.beams.size();
  const std::size_t wanted = std::min(all, static_cast<std::size_t>(config.beams));
  beams_.reserve(wanted);
  for (std::size_t i = 0; i < wanted; ++i) {
    const Beam& beam = view.beams[i * all / wanted];
    const double step_m = cell_m_ / DistanceField::kStepsPerCell;
    const double swept_m = spacing.rad * beam.range_m;
    const double variance_m2 = beam.sigma_m * beam.sigma_m +
                               config.map_sigma_m * config.map_sigma_m + cell_m_ * cell_m_ / 12 +
                               spacing.m * spacing.m + swept_m * swept_m;
    LevelBeam level{R_tilt * beam.point_m, beam.range_m, std::sqrt(variance_m2), {}};
    for (std::size_t steps = 0; steps < level.log_at.size(); ++steps) {
      const double off_m = static_cast<double>(steps) * step_m;
      const double fit = std::exp(-off_m * off_m / (2 * variance_m2));
      level.log_at[steps] =
          static_cast<float>(std::log(config.outlier_share + (1 - config.outlier_share) * fit));
    }
    beams_.push_back(level);
  }
}

SensorModel::Pose SensorModel::placed(const Particle& particle) {
  return {std::cos(particle.yaw_rad),
          std::sin(particle.yaw_rad),
          {particle.x_m, particle.y_m, particle.z_m}};
}

float SensorModel::beam_log(const LevelBeam& beam, std::uint8_t distance) const {
  const float log_fit = beam.log_at[distance & ~DistanceField::kUnknownBit];
  // Where the map knows nothing a surface nearby still speaks for the guess; none speaks neither
  // way.
  return (distance & DistanceField::kUnknownBit) != 0 ? std::max(log_fit, log_unknown_) : log_fit;
}

double SensorModel::temper() const {
  return beams_.empty()
             ? 0
             : std::min(1.0, config_.independent_beams / static_cast<double>(beams_.size()));
}

double SensorModel::log_likelihood(const Particle& particle, DistanceField::Cursor& cells,
                                   const DistanceField& field) const {
  const Pose pose = placed(particle);
  double sum = 0;
  for (const LevelBeam& beam : beams_) {
    sum += beam_log(beam, cells.at(field.cell_at(pose.of(beam.end_m))));
  }
  return temper() * sum;
}

double SensorModel::log_likelihood_along(const Particle& particle, DistanceField::Cursor& cells,
                                         const DistanceField& field) const {
  const Pose pose = placed(particle);
  double sum = 0;
  for (const LevelBeam& beam : beams_) {
    const float ends = beam_log(beam, cells.at(field.cell_at(pose.of(beam.end_m))));
    sum += ends > log_outlier_ && blocked(beam, pose, cells, field) ? log_outlier_ : ends;
  }
  return temper() * sum;
}

// Leaps as far as the field says that nothing is (sphere tracing, Hart 1996).
bool SensorModel::blocked(const LevelBeam& beam, const Pose& pose, DistanceField::Cursor& cells,
                          const DistanceField& field) const {
  const Eigen::Vector3d from = pose.of(eye_m_);
  const Eigen::Vector3d along = (pose.of(beam.end_m) - from) / beam.range_m;
  const double until_m = beam.range_m - kBefore_m - 3 * beam.sigma_m;
  double at_m = kBlind_m;
  while (at_m < until_m) {
    const std::uint8_t distance = cells.at(field.cell_at(from + at_m * along)) &
                                  static_cast<std::uint8_t>(~DistanceField::kUnknownBit);
    if (distance == 0) return true;
    const double free_cells = static_cast<double>(distance) / DistanceField::kStepsPerCell - 1;
    at_m += cell_m_ * std::max(0.7, free_cells);
  }
  return false;
}

double SensorModel::mean_likelihood(double log_likelihood) const {
  const double scale = temper() * static_cast<double>(beams_.size());
  return scale <= 0 ? 0 : std::exp(log_likelihood / scale);
}

}  // namespace cairn::localization
