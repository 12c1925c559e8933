// SPDX-License-Identifier: Apache-2.0
#include "localization/localizer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::localization {
namespace {

constexpr std::size_t kStepsKept = 256;
/// With fewer of a view's beams where the map knows something, the map has nothing to say.
constexpr double kShownShare = 0.4;
constexpr int kFewestShown = 60;
/// Farther apart than this, two places are two.
constexpr double kApart_m = 0.3;
constexpr double kApart_rad = 0.17;
/// A cluster's pose is at least this uncertain: particles are few.
constexpr double kClusterSigma_m = 0.05;
constexpr double kClusterSigma_rad = 0.03;
/// Another place counts if its particles weigh this share of all, and it fits this much as well.
constexpr double kRivalWeight = 0.3;
constexpr double kAsWell = 0.85;

bool apart(const Isometry& a, const Isometry& b) {
  return (a.translation() - b.translation()).head<2>().norm() > kApart_m ||
         std::abs(std::remainder(yaw_rad(a) - yaw_rad(b), 2 * std::numbers::pi)) > kApart_rad;
}

PoseBelief belief_around(const Isometry& T_map_body, double sigma_m, double sigma_rad) {
  PoseBelief belief;
  belief.T_map_body = T_map_body;
  belief.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  belief.covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  return belief;
}

}  // namespace

Localizer::Localizer(const LocalizerConfig& config)
    : config_{config},
      chain_{config.motion},
      filter_{config.filter, static_cast<std::uint64_t>(config.seed)} {
  if (config.begin_lost) forget();
}

Localizer::Pose Localizer::move(const OdometryFrame& frame) {
  if (chain_.last() && frame.utime <= chain_.last()->utime) steps_.clear();
  const Motion motion = chain_.put(frame);
  schedule_.move(frame.utime, motion);
  steps_.push_back({frame.utime, motion});
  if (steps_.size() > kStepsKept) {
    take_motion(steps_.front());
    steps_.pop_front();
  }
  Pose pose;
  pose.T_map_odom = schedule_.pose().T_map_body * frame.T_odom_body.inverse();
  pose.covariance = schedule_.pose().covariance;
  pose.certainty = schedule_.in_use().certainty;
  pose.correction_utime = schedule_.in_use().utime;
  return pose;
}

void Localizer::take_motion(const Step& step) {
  belief_ = moved(belief_, step.motion);
  filter_.move(step.motion, belief_.T_map_body);
}

void Localizer::forget() {
  certainty_ = Certainty::kLost;
  search_ = true;
  rival_views_ = 0;
  misfit_since_.reset();
  Correction correction = schedule_.in_use();
  correction.pose = schedule_.pose();
  correction.certainty = certainty_;
  schedule_.start(correction);
}

void Localizer::start_at(const Isometry& T_map_body, double sigma_m, double sigma_rad) {
  steps_.clear();
  belief_ = belief_around(T_map_body, sigma_m, sigma_rad);
  filter_.start_at(belief_);
  certainty_ = Certainty::kTracking;
  search_ = false;
  rival_views_ = 0;
  misfit_since_.reset();
  schedule_.start({chain_.last() ? chain_.last()->utime : 0, belief_, certainty_});
}

std::optional<LocalizerMemory> Localizer::memory() const {
  if (!chain_.last()) return std::nullopt;
  return LocalizerMemory{*chain_.last(), schedule_.pose().T_map_body, schedule_.pose().covariance,
                         schedule_.in_use().certainty};
}

void Localizer::resume(const LocalizerMemory& memory) {
  chain_.restore(Isometry::Identity(), memory.frame);
  belief_ = PoseBelief{};
  belief_.T_map_body = memory.T_map_body;
  belief_.covariance = memory.covariance;
  certainty_ = memory.certainty;
  search_ = certainty_ == Certainty::kLost;
  schedule_.start({memory.frame.utime, belief_, certainty_});
}

Localizer::Update Localizer::update(const stereo::DisparityImage& seen,
                                    const mapping::MapReplica& map,
                                    const mapping::MapReplica::Changes& changes) {
  Update update;
  field_.take(map, changes);
  while (!steps_.empty() && steps_.front().utime <= seen.utime) {
    take_motion(steps_.front());
    update.known_frame = steps_.front().utime == seen.utime;
    steps_.pop_front();
  }
  if (!update.known_frame) return update;
  const View view = make_view(seen, config_.view, static_cast<std::uint64_t>(config_.seed));
  refresh_field(view);
  const MapView map_view{map, field_, surfaces_};
  if (certainty_ == Certainty::kLost) {
    update.fit = fit_of(field_, view, belief_.T_map_body);
  } else {
    const Refinement refined = refine(map_view, view, belief_, config_.refinement);
    update.fit = refined.after;
    belief_ = refined.pose;
  }
  weigh(map_view, view, update.fit);
  update.in_time = schedule_.put({seen.utime, belief_, certainty_});
  return update;
}

void Localizer::refresh_field(const View& view) {
  std::vector<Eigen::Vector3d> ends;
  ends.reserve(view.beams.size());
  for (const Beam& beam : view.beams) ends.emplace_back(belief_.T_map_body * beam.point_m);
  (void)field_.work(ends, static_cast<std::size_t>(config_.field_blocks));
}

bool Localizer::map_shows_enough(const Fit& fit, const View& view) const {
  return fit.known >= kFewestShown &&
         fit.known >= kShownShare * static_cast<double>(view.beams.size());
}

void Localizer::weigh(const MapView& map, const View& view, const Fit& fit) {
  if (search_ && filter_.start_anywhere(field_, belief_.T_map_body)) search_ = false;
  if (!filter_.started()) {
    filter_.start_at(belief_around(belief_.T_map_body, kClusterSigma_m, kClusterSigma_rad));
  }
  if (filter_.weigh(field_, view).weighed) consider_rival(map, view, fit);
  judge(view, fit);
}

// The place that most particles are at, where it is not the one that is believed in.
void Localizer::consider_rival(const MapView& map, const View& view, const Fit& fit) {
  const auto clusters = filter_.clusters();
  const bool lost = certainty_ == Certainty::kLost;
  if (clusters.empty() || clusters.front().weight < 0.5 ||
      (!lost && !apart(clusters.front().pose.T_map_body, belief_.T_map_body))) {
    rival_views_ = 0;
    return;
  }
  PoseBelief there =
      belief_around(clusters.front().pose.T_map_body, kClusterSigma_m, kClusterSigma_rad);
  there.covariance += clusters.front().pose.covariance;
  const Refinement refined = refine(map, view, there, config_.refinement);
  const bool fits =
      map_shows_enough(refined.after, view) && refined.after.hit_share() >= config_.fits_share;
  const bool better = lost || !map_shows_enough(fit, view) ||
                      refined.after.hit_share() > fit.hit_share() + config_.rival_better;
  rival_views_ = fits && better ? rival_views_ + 1 : 0;
  if (rival_views_ < config_.rival_views) return;
  rival_views_ = 0;
  ++relocalised_;
  belief_ = refined.pose;
  certainty_ = Certainty::kTracking;
  misfit_since_.reset();
}

void Localizer::judge(const View& view, const Fit& fit) {
  if (certainty_ == Certainty::kLost) return;
  const bool shown = map_shows_enough(fit, view);
  const bool misfit = shown && fit.hit_share() < config_.lost_share;
  if (!misfit) {
    misfit_since_.reset();
  } else if (!misfit_since_) {
    misfit_since_ = view.utime;
  } else if (to_seconds(view.utime - *misfit_since_) > config_.lost_after_s) {
    certainty_ = Certainty::kLost;
    search_ = true;
    misfit_since_.reset();
    return;
  }
  certainty_ = another_place_fits(view, fit) ? Certainty::kAmbiguous : Certainty::kTracking;
}

bool Localizer::another_place_fits(const View& view, const Fit& fit) const {
  const auto clusters = filter_.clusters();
  return std::any_of(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
    if (cluster.weight < kRivalWeight || !apart(cluster.pose.T_map_body, belief_.T_map_body))
      return false;
    const Fit there = fit_of(field_, view, cluster.pose.T_map_body);
    return map_shows_enough(there, view) && there.hit_share() >= config_.fits_share &&
           there.hit_share() >= kAsWell * fit.hit_share();
  });
}

}  // namespace cairn::localization
