// SPDX-License-Identifier: Apache-2.0
#include "localization/particle_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

#include "localization/resampling.hpp"

namespace cairn::localization {
namespace {

using Vector4d = Eigen::Vector4d;
using Matrix4d = Eigen::Matrix4d;

/// Particles this near to each other are of one cluster.
constexpr double kClusterReach_m = 0.4;
constexpr double kClusterReach_rad = 0.35;
constexpr double kLightestCluster = 0.02;
constexpr std::size_t kMostClusters = 16;
/// Bins of the Kullback-Leibler count.
constexpr double kBin_m = 0.25;
constexpr double kBin_rad = 0.2;
/// Of a bin, when each holds one particle: the truth is within half of it.
constexpr double kHalfBin = 0.5;
/// How fast the running means of the fit follow it.
constexpr double kLately = 0.1;
constexpr double kUsually = 0.005;
constexpr double kMostRandom = 0.3;
/// Log-likelihoods this near to the best one differ by what the map gets wrong, not by where the
/// guess is: two places that look alike stay two.
constexpr double kNoWorse = 0.4;
/// Roll and pitch of a cluster: known from odometry to about this.
constexpr double kTiltSigma_rad = 0.01;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

/// x, y, z and yaw of a six-dimensional covariance.
Matrix4d upright(const Matrix6d& covariance) {
  constexpr int kKept[4] = {0, 1, 2, 5};
  Matrix4d kept;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) kept(i, j) = covariance(kKept[i], kKept[j]);
  }
  return kept;
}

Matrix6d upended(const Matrix4d& covariance) {
  constexpr int kKept[4] = {0, 1, 2, 5};
  Matrix6d whole = Matrix6d::Zero();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) whole(kKept[i], kKept[j]) = covariance(i, j);
  }
  whole(3, 3) = whole(4, 4) = kTiltSigma_rad * kTiltSigma_rad;
  return whole;
}

/// A square root of a covariance that may be singular.
Matrix4d square_root(const Matrix4d& covariance) {
  const Eigen::LDLT<Matrix4d> factors(covariance);
  const Vector4d scale = factors.vectorD().cwiseMax(0).cwiseSqrt();
  Matrix4d lower = factors.matrixL();
  return factors.transpositionsP().transpose() * (lower * scale.asDiagonal()).eval();
}

Vector4d difference(const Particle& from, const Particle& to) {
  return {to.x_m - from.x_m, to.y_m - from.y_m, to.z_m - from.z_m,
          wrapped(to.yaw_rad - from.yaw_rad)};
}

}  // namespace

void ParticleFilter::start_at(const PoseBelief& pose) {
  R_tilt_ = tilt_of(pose.T_map_body);
  const Matrix4d spread = square_root(upright(pose.covariance));
  const Eigen::Vector3d at = pose.T_map_body.translation();
  const double yaw = yaw_rad(pose.T_map_body);
  const auto count = static_cast<std::size_t>(config_.min_particles);
  particles_.assign(count, {});
  for (Particle& particle : particles_) {
    const Vector4d noise(random_.normal(), random_.normal(), random_.normal(), random_.normal());
    const Vector4d off = spread * noise;
    particle = {at.x() + off[0], at.y() + off[1], at.z() + off[2], wrapped(yaw + off[3]),
                1.0 / static_cast<double>(count)};
  }
  fit_lately_ = fit_usually_ = 0;
  weighed_ = false;
}

bool ParticleFilter::start_anywhere(const DistanceField& field, const Isometry& T_map_body) {
  const double z_m = T_map_body.translation().z();
  const FreeFloor floor(field, z_m + config_.body_middle_m, config_.clearance_m);
  if (floor.empty()) return false;
  R_tilt_ = tilt_of(T_map_body);
  particles_.assign(static_cast<std::size_t>(config_.global_particles), {});
  for (Particle& particle : particles_) {
    particle = anywhere(floor, z_m);
    particle.weight = 1.0 / static_cast<double>(particles_.size());
  }
  fit_lately_ = fit_usually_ = 0;
  weighed_ = false;
  return true;
}

Particle ParticleFilter::anywhere(const FreeFloor& floor, double z_m) {
  const Eigen::Vector2d at = floor.sample_m(random_);
  return {at.x(), at.y(), z_m, 2 * std::numbers::pi * (random_.uniform() - 0.5), 0};
}

Particle ParticleFilter::near(const Particle& particle, double spread) {
  Particle copy = particle;
  copy.x_m += spread * config_.jitter_m * random_.normal();
  copy.y_m += spread * config_.jitter_m * random_.normal();
  copy.yaw_rad = wrapped(copy.yaw_rad + spread * config_.jitter_rad * random_.normal());
  return copy;
}

void ParticleFilter::move(const Motion& motion, const Isometry& T_chain_body) {
  const Eigen::Matrix3d R_tilt_before = R_tilt_;
  R_tilt_ = tilt_of(T_chain_body);
  way_m_ += motion.T_from_to.translation().norm();
  turned_rad_ += std::abs(yaw_rad(motion.T_from_to));
  const Matrix4d spread = square_root(upright(motion.covariance));
  for (Particle& particle : particles_) {
    const Isometry T = pose_of(particle, R_tilt_before) * motion.T_from_to;
    const Vector4d noise(random_.normal(), random_.normal(), random_.normal(), random_.normal());
    const Vector4d off = spread * noise;
    const Eigen::Vector3d at = T * off.head<3>();
    particle.x_m = at.x();
    particle.y_m = at.y();
    particle.z_m = at.z();
    particle.yaw_rad = wrapped(yaw_rad(T) + off[3]);
  }
}

void ParticleFilter::weigh_all(const DistanceField& field, const SensorModel& model,
                               std::vector<double>& logs) {
  DistanceField::Cursor cells(field);
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    logs[i] = model.log_likelihood(particles_[i], cells, field);
  }
  const auto along =
      static_cast<std::size_t>(config_.along_share * static_cast<double>(particles_.size()));
  if (along == 0) return;
  std::vector<std::size_t> order(particles_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto better = [&](std::size_t a, std::size_t b) {
    return logs[a] != logs[b] ? logs[a] > logs[b] : a < b;
  };
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(along - 1),
                   order.end(), better);
  for (std::size_t i = 0; i < along; ++i) {
    logs[order[i]] = model.log_likelihood_along(particles_[order[i]], cells, field);
  }
}

ParticleFilter::Update ParticleFilter::weigh(const DistanceField& field, const View& view) {
  Update update;
  if (particles_.empty() || view.beams.empty() || field.cell_m() <= 0) return update;
  if (weighed_ && way_m_ < config_.weigh_every_m && turned_rad_ < config_.weigh_every_rad)
    return update;
  // A view is worth what is new in it: the same errors of the map, seen again, are no news.
  const double news =
      weighed_ ? std::min(1.0, way_m_ / config_.new_view_m + turned_rad_ / config_.new_view_rad)
               : 1;
  update.weighed = weighed_ = true;
  way_m_ = turned_rad_ = 0;
  const double sparse =
      std::cbrt(static_cast<double>(bins_held()) / static_cast<double>(particles_.size()));
  const SensorModel model(config_.sensor, view, R_tilt_, field.cell_m(),
                          {kHalfBin * kBin_m * sparse, kHalfBin * kBin_rad * sparse});
  std::vector<double> logs(particles_.size());
  weigh_all(field, model, logs);
  const double best = *std::max_element(logs.begin(), logs.end());
  update.best_fit = model.mean_likelihood(best);
  double sum = 0;
  double mean_log = 0;
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    mean_log += particles_[i].weight * logs[i];
    const double worse = std::max(0.0, best - logs[i] - kNoWorse);
    particles_[i].weight *= std::exp(-news * worse);
    sum += particles_[i].weight;
  }
  update.mean_fit = model.mean_likelihood(mean_log);
  for (Particle& particle : particles_) {
    particle.weight =
        sum > 0 ? particle.weight / sum : 1.0 / static_cast<double>(particles_.size());
  }
  const bool first = fit_usually_ == 0;
  fit_lately_ = first ? update.mean_fit : fit_lately_ + kLately * (update.mean_fit - fit_lately_);
  fit_usually_ =
      first ? update.mean_fit : fit_usually_ + kUsually * (update.mean_fit - fit_usually_);
  resample(field, update);
  return update;
}

void ParticleFilter::resample(const DistanceField& field, Update& update) {
  update.effective = effective_count(particles_);
  const double worse = fit_usually_ > 0 ? std::max(0.0, 1 - fit_lately_ / fit_usually_) : 0;
  const bool coarse = config_.resampling == "coarse";
  update.random_share = coarse ? CoarseSorting::kRandom : std::min(kMostRandom, worse);
  if (!coarse && update.effective > 0.5 * static_cast<double>(particles_.size())) {
    update.random_share = 0;
    return;
  }
  update.resampled = true;
  const double z_m = mean_z_m();
  FreeFloor floor;
  if (update.random_share > 0.01) {
    floor = FreeFloor(field, z_m + config_.body_middle_m, config_.clearance_m);
  }
  if (floor.empty()) update.random_share = 0;
  if (coarse) {
    // Less sure, wider.
    const double spread = 1 + 10 * (1 - update.best_fit);
    const CoarseSorting sorting{
        [&](const Particle& from) { return near(from, spread); },
        [&] { return floor.empty() ? near(particles_.front(), spread) : anywhere(floor, z_m); }};
    sorting.apply(particles_, random_);
    const std::size_t count = wanted_count();
    if (count < particles_.size()) {
      particles_ = resample_systematically(particles_, count, random_);
    }
    return;
  }
  particles_ = resample_systematically(particles_, wanted_count(), random_);
  for (Particle& particle : particles_) {
    const double weight = particle.weight;
    particle = random_.uniform() < update.random_share ? anywhere(floor, z_m) : near(particle, 1);
    particle.weight = weight;
  }
}

double ParticleFilter::mean_z_m() const {
  double z_m = 0;
  for (const Particle& particle : particles_) z_m += particle.weight * particle.z_m;
  return z_m;
}

// Those with weight that counts.
std::size_t ParticleFilter::bins_held() const {
  std::set<std::tuple<int, int, int>> bins;
  const double least = 0.1 / static_cast<double>(particles_.size());
  for (const Particle& particle : particles_) {
    if (particle.weight < least) continue;
    bins.emplace(static_cast<int>(std::floor(particle.x_m / kBin_m)),
                 static_cast<int>(std::floor(particle.y_m / kBin_m)),
                 static_cast<int>(std::floor(particle.yaw_rad / kBin_rad)));
  }
  return bins.size();
}

std::size_t ParticleFilter::wanted_count() const {
  const std::size_t most =
      std::max(particles_.size(), static_cast<std::size_t>(config_.max_particles));
  return std::clamp(kld_count(bins_held()), static_cast<std::size_t>(config_.min_particles), most);
}

std::vector<Cluster> ParticleFilter::clusters() const {
  std::vector<std::size_t> left(particles_.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::vector<Cluster> found;
  for (std::size_t round = 0; round < kMostClusters && !left.empty(); ++round) {
    const std::size_t seed =
        *std::max_element(left.begin(), left.end(), [&](std::size_t a, std::size_t b) {
          return particles_[a].weight != particles_[b].weight
                     ? particles_[a].weight < particles_[b].weight
                     : a > b;
        });
    const auto belongs = [&](std::size_t i) {
      const Vector4d off = difference(particles_[seed], particles_[i]);
      return off.head<2>().norm() <= kClusterReach_m && std::abs(off[3]) <= kClusterReach_rad;
    };
    const auto rest = std::stable_partition(left.begin(), left.end(), belongs);
    double weight = 0;
    Vector4d mean = Vector4d::Zero();
    for (auto i = left.begin(); i != rest; ++i) {
      weight += particles_[*i].weight;
      mean += particles_[*i].weight * difference(particles_[seed], particles_[*i]);
    }
    if (weight > 0) mean /= weight;
    Matrix4d covariance = Matrix4d::Zero();
    for (auto i = left.begin(); i != rest; ++i) {
      const Vector4d off = difference(particles_[seed], particles_[*i]) - mean;
      covariance += particles_[*i].weight * off * off.transpose();
    }
    if (weight >= kLightestCluster) {
      const Particle& from = particles_[seed];
      const Particle middle{from.x_m + mean[0], from.y_m + mean[1], from.z_m + mean[2],
                            wrapped(from.yaw_rad + mean[3]), weight};
      found.push_back({{pose_of(middle, R_tilt_), upended(covariance / weight)}, weight});
    }
    left.erase(left.begin(), rest);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Cluster& a, const Cluster& b) { return a.weight > b.weight; });
  return found;
}

}  // namespace cairn::localization
