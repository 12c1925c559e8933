// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "planning/navigator.hpp"

namespace cairn::planning {
namespace {

constexpr double kTurned_rad = 0.07;
constexpr double kStep_m = 0.05;
constexpr double kStep_rad = 0.15;
constexpr double kPastTrouble_m = 0.9;
constexpr double kWatch_s = 2.5;
constexpr double kMapComes_s = 6;
constexpr int kTriesForGoal = 4;
constexpr int kTriesForView = 2;
constexpr double kAstray_m = 0.35;
constexpr double kThere_m = 0.15;
constexpr double kThere_rad = 0.25;
constexpr double kSpot_m = 0.15;
constexpr double kHereabouts_m = 1.5;
constexpr double kLookAside_rad = 0.6;
constexpr double kBehind_m = 0.25;
constexpr double kWorthBacking_m = 0.1;
constexpr double kLeftBehind_m = 0.03;  // it takes that long to stop
constexpr double kSearchForSelf_s = 40;
constexpr double kCarried_m = 0.15;

std::int64_t microseconds(double seconds) { return static_cast<std::int64_t>(1e6 * seconds); }

}  // namespace

void Navigator::rest() {
  activity_ = Activity::kNone;
  turns_rad_.clear();
  if (follower_.following()) {
    follower_.drop();
    ++path_count_;
  }
}

// ---- turning and settling ----

void Navigator::begin_turns(std::vector<double> turns_rad) {
  std::reverse(turns_rad.begin(), turns_rad.end());
  rest();
  turns_rad_ = std::move(turns_rad);
  last_heading_rad_ = now_.in_odom.heading_rad;
  activity_ = Activity::kTurning;
  begin_progress();
}

void Navigator::go_on_turning() {
  turns_rad_.back() -= wrapped_rad(now_.in_odom.heading_rad - last_heading_rad_);
  last_heading_rad_ = now_.in_odom.heading_rad;
  if (std::abs(turns_rad_.back()) < kTurned_rad) {
    turns_rad_.pop_back();
    if (turns_rad_.empty()) begin_settling();
  } else if (!getting_on()) {
    recover();
  }
}

void Navigator::begin_settling() {
  rest();
  if (mission_ == Mission::kExplore && !looked_round_ && recoveries_ == 0) looked_round_ = true;
  activity_ = Activity::kSettling;
  turned_at_ = now_.utime;
  settled_at_ = now_.utime + microseconds(config_.settle_s);
}

// What a map that came to a stand does not show was not looked at in vain.
void Navigator::go_on_settling() {
  const bool shown = now_.map_through >= turned_at_;
  if (now_.utime < settled_at_ ||
      (view_ && !shown && now_.utime < settled_at_ + microseconds(kMapComes_s))) {
    return;
  }
  rest();
  if (looks_again_at_m_) return looked_again();
  const Pose2 here = in_map();
  looked_ = shown && view_ && (view_->pose.at_m - here.at_m).norm() < kThere_m &&
            std::abs(wrapped_rad(view_->pose.heading_rad - here.heading_rad)) < kThere_rad;
  if (mission_ == Mission::kGo && (destination_.at_m - here.at_m).norm() < kThere_m)
    finish(Phase::kArrived, "there");
}

// ---- following ----

void Navigator::go_on_following() {
  if (follower_.arrived()) {
    if (mission_ == Mission::kGo && !looks_again_at_m_) return finish(Phase::kArrived, "there");
    return begin_settling();
  }
  if (follower_.astray_m() > kAstray_m) return rest();
  if (now_.utime > give_up_at_) return give_up_target();
  if (now_.allowed_mps > 0 || follower_.turning()) allowed_at_ = now_.utime;
  const bool refused = now_.utime - allowed_at_ > microseconds(config_.refused_s);
  if (refused || !getting_on()) recover();
}

// ---- trouble ----

void Navigator::begin_progress() {
  progress_from_ = now_.in_odom;
  progress_at_ = now_.utime;
  allowed_at_ = now_.utime;
}

bool Navigator::getting_on() {
  const double moved_m = (now_.in_odom.at_m - progress_from_.at_m).norm();
  const double turned_rad = wrapped_rad(now_.in_odom.heading_rad - progress_from_.heading_rad);
  if (moved_m > kStep_m || std::abs(turned_rad) > kStep_rad) begin_progress();
  if (recoveries_ > 0 && (now_.in_odom.at_m - recovered_at_m_).norm() > kPastTrouble_m)
    recoveries_ = 0;
  return now_.utime - progress_at_ < microseconds(config_.stuck_s);
}

void Navigator::recover() {
  ++recoveries_;
  recovered_at_m_ = now_.in_odom.at_m;
  if (recoveries_ > (mission_ == Mission::kGo ? kTriesForGoal : kTriesForView))
    return give_up_target();
  if (recoveries_ % 2 != 0) return take_as_blocked();
  if (begin_backing_off()) return;
  say(Phase::kRecovering, "does not get on: looks to both sides");
  begin_turns({kLookAside_rad, -2 * kLookAside_rad, kLookAside_rad});
}

// The oftener something blocks the way hereabouts, the wider it is taken to be.
void Navigator::take_as_blocked() {
  say(Phase::kRecovering, "does not get on: takes it that something is in the way");
  const Pose2 here = in_map();
  const auto near = std::count_if(blocked_.begin(), blocked_.end(), [&](const Blocked& entry) {
    return (entry.spot.at_m - here.at_m).norm() < kHereabouts_m;
  });
  const double radius_m = kSpot_m * static_cast<double>(1 << std::min<std::ptrdiff_t>(near, 2));
  const double before_m = 0.5 * robot_.length_m + radius_m;
  blocked_.push_back({{here.at_m + before_m * ahead(here.heading_rad), radius_m},
                      now_.utime + microseconds(config_.blocked_memory_s)});
  drop_target();
  model_.renew();
  rest();
}

// From farther away the cameras see what is in the way.
bool Navigator::begin_backing_off() {
  rest();
  if (behind_m_ < kWorthBacking_m) return false;
  way_back_m_ = trail_.way_back_m(behind_m_ + kBehind_m);
  std::reverse(way_back_m_.begin(), way_back_m_.end());
  if (!aim_back()) return false;
  say(Phase::kRecovering, "does not get on: backs off the way it came, to see");
  activity_ = Activity::kBackingOff;
  begin_progress();
  return true;
}

// The next point of the way back must lie behind the robot.
bool Navigator::aim_back() {
  const Pose2 T_robot_map = inverse(in_map());
  while (!way_back_m_.empty() &&
         moved(T_robot_map, {way_back_m_.back(), 0}).at_m.norm() < kBehind_m) {
    way_back_m_.pop_back();
  }
  if (way_back_m_.empty()) return false;
  const Eigen::Vector2d next_m = moved(T_robot_map, {way_back_m_.back(), 0}).at_m;
  return next_m.x() < -std::abs(next_m.y());
}

void Navigator::go_on_backing_off() {
  if (behind_m_ > kLeftBehind_m && aim_back() && getting_on()) return;
  drop_target();
  begin_settling();
  settled_at_ += microseconds(kWatch_s);
}

void Navigator::give_up_target() {
  recoveries_ = 0;
  if (mission_ == Mission::kGo) {
    return finish(Phase::kRefused, "unreachable: tried and did not get there");
  }
  if (view_) {
    exploration_.give_up_in_view(model_.ground(), view_->pose, Exploration::kMostLooks);
  } else {
    looked_round_ = true;
  }
  drop_target();
  rest();
}

// Where the robot stands nothing has come nearer since it knew, as long as it was not carried.
void Navigator::be_lost() {
  if (activity_ != Activity::kLost) {
    rest();
    drop_target();
    activity_ = Activity::kLost;
    lost_since_ = now_.utime;
    lost_at_m_ = now_.in_odom.at_m;
    turns_rad_ = {2 * std::numbers::pi};
  }
  const bool carried = (now_.in_odom.at_m - lost_at_m_).norm() > kCarried_m;
  if (carried || now_.utime > lost_since_ + microseconds(kSearchForSelf_s)) turns_rad_.clear();
  say(Phase::kRecovering,
      turns_rad_.empty() ? "lost: waits to be told where it is" : "lost: turns to see where it is");
}

}  // namespace cairn::planning
