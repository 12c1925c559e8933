// SPDX-License-Identifier: Apache-2.0
#include "localization/localizer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::localization {
namespace {

constexpr std::size_t kStepsKept = 256;
/// With fewer of a view's beams at things that stand, or a smaller share of all where the map knows
/// something, the map has nothing to say.
constexpr int kFewestStanding = 40;
constexpr double kShownShare = 0.4;
/// Farther apart than this, two places are two.
constexpr double kApart_m = 0.3;
constexpr double kApart_rad = 0.17;
/// A cluster's pose is at least this uncertain: particles are few.
constexpr double kClusterSigma_m = 0.05;
constexpr double kClusterSigma_rad = 0.03;
/// Places are looked at whose particles weigh this share of all.
constexpr double kRivalWeight = 0.1;
constexpr double kHeaviestFrom = 0.4;
/// A place with this share is the one, even if the other fits nearly as well.
constexpr double kDecided = 0.95;
/// A place fits as well as another with this part of its share.
constexpr double kAsWell = 0.85;
/// Nothing is learned from the map while the robot moved less than this, or where odometry cannot
/// have drifted farther since that part of the map was made.
constexpr double kStands_m = 0.005;
constexpr double kStands_rad = 0.005;
constexpr double kLeastDrift_m = 0.001;
constexpr double kLeastDrift_rad = 0.0005;
constexpr double kAllNew_m = 1e3;
/// Views in a row that must fit before where it was is where it is again.
constexpr int kFitsAgain_views = 8;

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

PoseBelief around(const Isometry& T_map_body) {
  return belief_around(T_map_body, kClusterSigma_m, kClusterSigma_rad);
}

}  // namespace

Localizer::Localizer(const LocalizerConfig& config)
    : config_{config},
      chain_{config.motion},
      filter_{config.filter, static_cast<std::uint64_t>(config.seed)} {}

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
  const PoseBelief before = belief_;
  belief_ = moved(before, step.motion);
  belief_utime_ = step.utime;
  rival_ = rival_ * step.motion.T_from_to;
  way_m_ += step.motion.T_from_to.translation().norm();
  turned_rad_ += rotation_angle_rad(step.motion.T_from_to.linear());
  // Other parts of the map come into view, with errors of their own.
  belief_.pose_with_map *=
      std::exp(-step.motion.T_from_to.translation().norm() / config_.filter.new_view_m -
               rotation_angle_rad(step.motion.T_from_to.linear()) / config_.filter.new_view_rad);
  // Particles move as odometry is known to mean it.
  Motion meant = step.motion;
  meant.T_from_to = before.T_map_body.inverse() * belief_.T_map_body;
  filter_.move(meant, belief_.T_map_body);
}

void Localizer::forget() {
  certainty_ = Certainty::kLost;
  forgotten_ = search_ = true;
  looks_alike_ = false;
  rival_views_ = 0;
  misfit_since_.reset();
  schedule_.start({belief_utime_, belief_, certainty_});
}

void Localizer::start_at(const Isometry& T_map_body, double sigma_m, double sigma_rad) {
  steps_.clear();
  be_at(belief_around(T_map_body, sigma_m, sigma_rad));
  looks_alike_ = false;
  filter_.start_at(belief_);
  provenance_.start({});
  way_m_ = kAllNew_m;
  belief_utime_ = chain_.last() ? chain_.last()->utime : 0;
  schedule_.start({belief_utime_, belief_, certainty_});
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
  forgotten_ = search_ = certainty_ == Certainty::kLost;
  provenance_.start(belief_);
  belief_utime_ = memory.frame.utime;
  schedule_.start({belief_utime_, belief_, certainty_});
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
  const Refinement refined = corrected(map_view, view);
  update.fit = refined.after;
  fits_again_ = fits(refined.after, view) ? fits_again_ + 1 : 0;
  if (certainty_ != Certainty::kLost) {
    belief_ = refined.pose;
  } else if (!forgotten_ && fits_again_ >= kFitsAgain_views) {
    be_at(refined.pose);
    filter_.start_at(around(belief_.T_map_body));
  }
  look_around(map_view, view, update.fit);
  judge(view, update.fit);
  update.in_time = schedule_.put({seen.utime, belief_, certainty_});
  return update;
}

Refinement Localizer::corrected(const MapView& map, const View& view) {
  const MapAuthority authority = provenance_.look(field_, view, belief_);
  const Vector6d drift = authority.drift.diagonal();
  const bool stands = way_m_ < kStands_m && turned_rad_ < kStands_rad;
  const bool drifted = drift.head<3>().maxCoeff() > kLeastDrift_m * kLeastDrift_m ||
                       drift.tail<3>().maxCoeff() > kLeastDrift_rad * kLeastDrift_rad;
  if (stands || !drifted) {
    Refinement as_it_is;
    as_it_is.pose = belief_;
    as_it_is.before = as_it_is.after = fit_of(field_, view, belief_.T_map_body);
    return as_it_is;
  }
  way_m_ = turned_rad_ = 0;
  return refine(map, view, belief_, authority, config_.refinement);
}

void Localizer::refresh_field(const View& view) {
  std::vector<Eigen::Vector3d> ends;
  ends.reserve(view.beams.size());
  for (const Beam& beam : view.beams) ends.emplace_back(belief_.T_map_body * beam.point_m);
  (void)field_.work(ends, static_cast<std::size_t>(config_.field_blocks));
}

bool Localizer::shown(const Fit& fit, const View& view) {
  return fit.standing_known >= kFewestStanding &&
         fit.known >= kShownShare * static_cast<double>(view.beams.size());
}

double Localizer::share(const Fit& fit) {
  return fit.standing_known == 0 ? 0 : static_cast<double>(fit.standing_hits) / fit.standing_known;
}

bool Localizer::fits(const Fit& fit, const View& view) const {
  return shown(fit, view) && share(fit) >= config_.fits_share;
}

void Localizer::be_at(const PoseBelief& pose) {
  belief_ = pose;
  certainty_ = Certainty::kTracking;
  forgotten_ = search_ = false;
  rival_views_ = 0;
  misfit_since_.reset();
}

void Localizer::look_around(const MapView& map, const View& view, const Fit& fit) {
  if (search_ && filter_.start_anywhere(field_, belief_.T_map_body)) search_ = false;
  if (!filter_.started() && certainty_ != Certainty::kLost) {
    filter_.start_at(around(belief_.T_map_body));
  }
  if (!filter_.weigh(field_, view).weighed) return;
  const std::vector<Cluster> clusters = filter_.clusters();
  consider_rival(map, view, fit, clusters);
  looks_alike_ = another_place_fits(view, clusters);
}

// The place that most particles are at, where it is not the one that is believed in. A robot that
// sees what it expects, or what the map has nothing to say of, stays where it is.
void Localizer::consider_rival(const MapView& map, const View& view, const Fit& fit,
                               const std::vector<Cluster>& clusters) {
  const bool lost = certainty_ == Certainty::kLost;
  if ((!lost && !misfit_since_) || clusters.empty() || clusters.front().weight < kHeaviestFrom ||
      (!lost && !apart(clusters.front().pose.T_map_body, belief_.T_map_body))) {
    rival_views_ = 0;
    return;
  }
  PoseBelief there = around(clusters.front().pose.T_map_body);
  there.covariance += clusters.front().pose.covariance;
  const Refinement refined = refine(map, view, there, {there.covariance, {}}, config_.refinement);
  const bool better = lost || !shown(fit, view) ||
                      share(refined.after) > share(fit) + config_.rival_better ||
                      clusters.front().weight > kDecided;
  const bool same = rival_views_ == 0 || !apart(rival_, refined.pose.T_map_body);
  rival_ = refined.pose.T_map_body;
  rival_views_ = fits(refined.after, view) && better ? (same ? rival_views_ + 1 : 1) : 0;
  if (rival_views_ < config_.rival_views) return;
  ++relocalised_;
  be_at(refined.pose);
  provenance_.start({});
}

void Localizer::judge(const View& view, const Fit& fit) {
  if (certainty_ == Certainty::kLost) return;
  if (!shown(fit, view) || share(fit) >= config_.lost_share) {
    misfit_since_.reset();
  } else if (!misfit_since_) {
    misfit_since_ = view.utime;
  } else if (to_seconds(view.utime - *misfit_since_) > config_.lost_after_s) {
    certainty_ = Certainty::kLost;
    search_ = true;
    fits_again_ = 0;
    misfit_since_.reset();
    return;
  }
  certainty_ = looks_alike_ ? Certainty::kAmbiguous : Certainty::kTracking;
}

bool Localizer::another_place_fits(const View& view, const std::vector<Cluster>& clusters) const {
  const double here = share(fit_of(field_, view, belief_.T_map_body));
  return std::any_of(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
    if (cluster.weight < kRivalWeight || !apart(cluster.pose.T_map_body, belief_.T_map_body))
      return false;
    const Fit there = fit_of(field_, view, cluster.pose.T_map_body);
    return fits(there, view) && share(there) >= kAsWell * here;
  });
}

}  // namespace cairn::localization
