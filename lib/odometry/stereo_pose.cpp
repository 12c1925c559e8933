// SPDX-License-Identifier: Apache-2.0
#include "odometry/stereo_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

namespace cairn::odometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

constexpr double kGate = 11.34;  // chi-square, 3 degrees of freedom, 99 %
constexpr double kScaleQuantile = 0.3;
constexpr double kChiSquareAtQuantile = 1.424;  // 3 degrees of freedom, 30 %
constexpr double kMaxNoiseScale = 9;
constexpr double kHuber = 1.5;  // standard deviations
constexpr int kMaxTriples = 100;
constexpr double kWantedLuck = 0.999;
constexpr int kTripleSteps = 6;
constexpr int kRefineSteps = 10;
constexpr int kRefineRounds = 3;
constexpr double kStepDone = 1e-7;
constexpr double kMinDepth_m = 1e-2;
constexpr double kBehind = 1e12;  // squared distance of a point that would lie behind the camera
constexpr double kMinVarianceScale = 0.25;
constexpr double kMaxConditionSigma = 1.0;  // m or rad: a pose that open is none

struct Residual {
  Vector3d error;      // seen - predicted
  Matrix36d jacobian;  // of the prediction, by a small motion of the points
  Matrix3d information;
};

class Problem {
 public:
  Problem(const std::vector<PointPair>& pairs, const stereo::RectifiedCamera& camera,
          const PixelNoise& noise)
      : pairs_{pairs}, camera_{camera}, fb_{camera.f_px * camera.baseline_m} {
    const double position = noise.position_sigma_px * noise.position_sigma_px;
    const double disparity = noise.disparity_sigma_px * noise.disparity_sigma_px;
    noise_information_ = Vector3d(1 / position, 1 / position, 1 / disparity);
    points_.reserve(pairs.size());
    for (const PointPair& pair : pairs) points_.push_back(to_point(pair.anchor, camera));
  }

  [[nodiscard]] std::size_t size() const { return pairs_.size(); }

  /// Nothing if the point lies behind the camera.
  [[nodiscard]] std::optional<Residual> residual(std::size_t i, const Isometry& T) const {
    const Vector3d p = T * points_[i];
    if (p.z() < kMinDepth_m) return std::nullopt;
    const double f = camera_.f_px;
    const double inverse_z = 1 / p.z();
    Matrix3d by_point;
    by_point << f * inverse_z, 0, -f * p.x() * inverse_z * inverse_z,  //
        0, f * inverse_z, -f * p.y() * inverse_z * inverse_z,          //
        0, 0, -fb_ * inverse_z * inverse_z;
    Residual r;
    const StereoPixel predicted = to_pixel(p, camera_);
    const StereoPixel& seen = pairs_[i].seen;
    r.error = {seen.u_px - predicted.u_px, seen.v_px - predicted.v_px,
               seen.disparity_px - predicted.disparity_px};
    Matrix36d point_by_motion;
    point_by_motion << Matrix3d::Identity(), Matrix3d::Zero();
    point_by_motion.rightCols<3>() << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
    r.jacobian = by_point * point_by_motion;
    const Vector3d by_anchor = by_point * (T.linear() * points_[i]) *
                               (-pairs_[i].anchor_sigma_px / pairs_[i].anchor.disparity_px);
    r.information = inverse_of_noise_and(by_anchor);
    return r;
  }

  [[nodiscard]] double distance2(std::size_t i, const Isometry& T) const {
    const auto r = residual(i, T);
    return r ? std::max(0.0, r->error.dot(r->information * r->error)) : kBehind;
  }

 private:
  /// (noise + g g^T)^-1 (Sherman and Morrison 1950), which stays exact where g is huge.
  [[nodiscard]] Matrix3d inverse_of_noise_and(const Vector3d& g) const {
    const Vector3d weighted = noise_information_.cwiseProduct(g);
    Matrix3d information = -weighted * weighted.transpose() / (1 + g.dot(weighted));
    information.diagonal() += noise_information_;
    return information;
  }

  const std::vector<PointPair>& pairs_;
  const stereo::RectifiedCamera& camera_;
  double fb_;
  Vector3d noise_information_;
  std::vector<Vector3d> points_;
};

struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double weighted_squares = 0;
  double weight_sum = 0;
};

enum class Weights { kEqual, kRobust };

NormalEquations build(const Problem& problem, const std::vector<std::size_t>& chosen,
                      const Isometry& T, Weights weights) {
  NormalEquations equations;
  for (const std::size_t i : chosen) {
    const auto r = problem.residual(i, T);
    if (!r) continue;
    const double squares = r->error.dot(r->information * r->error);
    const double distance = std::sqrt(std::max(squares, 0.0));
    const bool full = weights == Weights::kEqual || distance <= kHuber;
    const double weight = full ? 1.0 : kHuber / distance;
    const Eigen::Matrix<double, 6, 3> weighted = weight * r->jacobian.transpose() * r->information;
    equations.information += weighted * r->jacobian;
    equations.gradient += weighted * r->error;
    equations.weighted_squares += weight * squares;
    equations.weight_sum += weight;
  }
  return equations;
}

Isometry moved(const Isometry& T, const Vector6d& step) {
  Isometry motion = Isometry::Identity();
  motion.linear() = exp_so3(step.tail<3>());
  motion.translation() = step.head<3>();
  return motion * T;
}

std::optional<Isometry> gauss_newton(const Problem& problem, const std::vector<std::size_t>& chosen,
                                     Isometry T, int max_steps,
                                     Weights weights = Weights::kRobust) {
  for (int i = 0; i < max_steps; ++i) {
    const NormalEquations equations = build(problem, chosen, T, weights);
    const Eigen::LDLT<Matrix6d> solver(equations.information);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
    const Vector6d step = solver.solve(equations.gradient);
    if (!step.allFinite()) return std::nullopt;
    T = moved(T, step);
    if (step.norm() < kStepDone) break;
  }
  return T;
}

/// The pairs within the gate; the gate widens with the noise that the better pairs show, up to
/// kMaxNoiseScale times.
std::vector<std::size_t> fitting(const Problem& problem, const Isometry& T) {
  std::vector<double> distances2(problem.size());
  for (std::size_t i = 0; i < distances2.size(); ++i) distances2[i] = problem.distance2(i, T);
  std::vector<double> sorted = distances2;
  const auto at = sorted.begin() +
                  static_cast<std::ptrdiff_t>(kScaleQuantile * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), at, sorted.end());
  const double scale = std::clamp(*at / kChiSquareAtQuantile, 1.0, kMaxNoiseScale);
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < distances2.size(); ++i) {
    if (distances2[i] <= scale * kGate) result.push_back(i);
  }
  return result;
}

/// Sum of squared distances, each cut off at the gate (Torr and Zisserman 2000).
double truncated_cost(const Problem& problem, const Isometry& T, std::size_t& inliers) {
  double cost = 0;
  inliers = 0;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    const double distance2 = problem.distance2(i, T);
    cost += std::min(distance2, kGate);
    if (distance2 <= kGate) ++inliers;
  }
  return cost;
}

int triples_needed(std::size_t inliers, std::size_t all) {
  const double share = static_cast<double>(inliers) / static_cast<double>(all);
  const double hit = share * share * share;
  if (hit > 1 - 1e-9) return 1;
  if (hit < 1e-9) return kMaxTriples;
  const double needed = std::log(1 - kWantedLuck) / std::log(1 - hit);
  return static_cast<int>(std::clamp(std::ceil(needed), 1.0, static_cast<double>(kMaxTriples)));
}

class Search {
 public:
  Search(const Problem& problem, const Isometry& guess) : problem_{problem}, best_{guess} {
    best_cost_ = truncated_cost(problem, guess, inliers_);
  }

  bool consider(const std::optional<Isometry>& T) {
    if (!T) return false;
    std::size_t inliers = 0;
    const double cost = truncated_cost(problem_, *T, inliers);
    if (!(cost < best_cost_)) return false;
    best_cost_ = cost;
    best_ = *T;
    inliers_ = inliers;
    return true;
  }

  /// Fits the best so far to all that agrees with it (Chum, Matas and Kittler 2003).
  void polish() {
    const auto chosen = fitting(problem_, best_);
    if (chosen.size() >= 3) consider(gauss_newton(problem_, chosen, best_, kTripleSteps));
  }

  [[nodiscard]] const Isometry& best() const { return best_; }
  [[nodiscard]] std::size_t inliers() const { return inliers_; }

 private:
  const Problem& problem_;
  Isometry best_;
  double best_cost_ = 0;
  std::size_t inliers_ = 0;
};

Isometry search(const Problem& problem, const Isometry& guess, std::uint32_t seed) {
  Search search(problem, guess);
  std::vector<std::size_t> all(problem.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  search.consider(gauss_newton(problem, all, guess, kRefineSteps));

  std::mt19937 random(seed);
  const auto pick = [&] { return static_cast<std::size_t>(random() % problem.size()); };
  for (int i = 0; i < triples_needed(search.inliers(), problem.size()); ++i) {
    const std::vector<std::size_t> triple{pick(), pick(), pick()};
    if (triple[0] == triple[1] || triple[1] == triple[2] || triple[0] == triple[2]) continue;
    if (search.consider(gauss_newton(problem, triple, guess, kTripleSteps, Weights::kEqual))) {
      search.polish();
    }
  }
  return search.best();
}

}  // namespace

Vector3d to_point(const StereoPixel& pixel, const stereo::RectifiedCamera& camera) {
  const double z_m = camera.f_px * camera.baseline_m / pixel.disparity_px;
  return {(pixel.u_px - camera.cx_px) * z_m / camera.f_px,
          (pixel.v_px - camera.cy_px) * z_m / camera.f_px, z_m};
}

StereoPixel to_pixel(const Vector3d& point, const stereo::RectifiedCamera& camera) {
  return {camera.f_px * point.x() / point.z() + camera.cx_px,
          camera.f_px * point.y() / point.z() + camera.cy_px,
          camera.f_px * camera.baseline_m / point.z()};
}

std::optional<StereoPose> solve_stereo_pose(const std::vector<PointPair>& pairs,
                                            const stereo::RectifiedCamera& camera,
                                            const PixelNoise& noise,
                                            const Isometry& guess_T_new_anchor, int min_inliers,
                                            std::uint32_t seed) {
  const auto enough = static_cast<std::size_t>(std::max(min_inliers, 3));
  if (pairs.size() < enough) return std::nullopt;
  const Problem problem(pairs, camera, noise);
  Isometry T = search(problem, guess_T_new_anchor, seed);
  std::vector<std::size_t> inliers = fitting(problem, T);
  for (int round = 0; round < kRefineRounds && inliers.size() >= enough; ++round) {
    const auto refined = gauss_newton(problem, inliers, T, kRefineSteps);
    if (!refined) return std::nullopt;
    T = *refined;
    inliers = fitting(problem, T);
  }
  if (inliers.size() < enough) return std::nullopt;

  const NormalEquations equations = build(problem, inliers, T, Weights::kRobust);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> spectrum(equations.information);
  if (!(spectrum.eigenvalues()[0] > 1 / (kMaxConditionSigma * kMaxConditionSigma))) {
    return std::nullopt;
  }
  const double freedom = std::max(1.0, 3 * equations.weight_sum - 6);
  const double scale = std::max(kMinVarianceScale, equations.weighted_squares / freedom);
  StereoPose pose;
  pose.T_new_anchor = rigid(T);
  pose.covariance = scale * equations.information.inverse();
  pose.is_inlier.assign(pairs.size(), false);
  for (const std::size_t i : inliers) pose.is_inlier[i] = true;
  pose.inliers = static_cast<int>(inliers.size());
  if (!pose.covariance.allFinite() || !pose.T_new_anchor.matrix().allFinite()) return std::nullopt;
  return pose;
}

}  // namespace cairn::odometry
