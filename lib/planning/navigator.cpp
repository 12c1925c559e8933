// SPDX-License-Identifier: Apache-2.0
#include "planning/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "planning/path_smoothing.hpp"

namespace cairn::planning {
namespace {

constexpr std::int64_t kCarryPose_us = 200'000;
constexpr std::int64_t kStale_us = 400'000;
constexpr std::int64_t kMapComes_us = 6'000'000;
constexpr std::int64_t kMapBehind_us = 2'000'000;  // of a mapper that keeps up, at most
constexpr double kEscape_m = 0.35;  // around the robot, ways may lead nearer to obstacles
constexpr double kJump_m = 0.5;     // of the pose from one step to the next: put down elsewhere
constexpr double kHere_m = 0.08;
constexpr double kNoise_m = 0.06;  // that a way may come nearer to obstacles than planned
constexpr double kShift_m = 0.06;  // of the map under the odometry frame: the way is laid anew
constexpr double kShift_rad = 0.05;
constexpr double kResolved = 0.3;  // share of a view's unknown floor that is not worth going on
constexpr int kSureOfNothing = 5;
constexpr double kEnclosed_m2 = 0.5;
constexpr double kSlowest_mps = 0.12;  // where there is no room to spare
constexpr double kSpeedPerRoom = 1.2;  // m/s more for each metre of room
constexpr double kBackTurn_radps = 0.5;
constexpr double kRoomToTurn_m = 0.01;
constexpr double kGentle_mps = 0.045;
constexpr double kReckoned_mps = 0.3;
constexpr double kSamePlace_m = 0.4;
constexpr int kLooksAgain = 2;

std::string words(const char* format, double number) {
  char text[128];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

}  // namespace

Navigator::Navigator(const NavigatorConfig& config, const RobotConfig& robot)
    : config_{config},
      robot_{robot},
      model_{config.ground, config.route, robot},
      exploration_{config.exploration},
      follower_{config.follower, robot},
      trail_{0.5 * robot.width_m, config.unseen_radius_m} {}

Pose2 Navigator::in_map() const { return moved(now_.T_map_odom, now_.in_odom); }

// ---- missions ----

void Navigator::begin(Mission mission, std::int64_t goal_id) {
  mission_ = mission;
  goal_id_ = goal_id;
  report_.goal_id = goal_id;
  nothing_wanted_ = 0;
  recoveries_ = 0;
  looked_again_at_m_.clear();
  drop_target();
  rest();
}

void Navigator::explore(std::int64_t goal_id) {
  begin(Mission::kExplore, goal_id);
  say(Phase::kExploring, "about to look around");
}

void Navigator::go(std::int64_t goal_id, const Destination& destination) {
  begin(Mission::kGo, goal_id);
  destination_ = destination;
  say(Phase::kDriving, "looking for a way");
}

void Navigator::cancel(std::int64_t goal_id) {
  begin(Mission::kNone, goal_id);
  say(Phase::kIdle, "told to forget the goal");
}

void Navigator::finish(Phase phase, const std::string& reason) {
  mission_ = Mission::kNone;
  drop_target();
  rest();
  say(phase, reason);
}

void Navigator::say(Phase phase, const std::string& reason) {
  report_.phase = phase;
  report_.reason = reason;
}

PlanMemory Navigator::memory() const {
  return {mission_,      goal_id_,       destination_,   looked_round_,
          report_.phase, report_.reason, trail_.floor(), exploration_.looks()};
}

void Navigator::restore(PlanMemory memory) {
  if (memory.mission == Mission::kExplore) explore(memory.goal_id);
  if (memory.mission == Mission::kGo) go(memory.goal_id, memory.destination);
  if (memory.mission == Mission::kNone) {
    report_.goal_id = memory.goal_id;
    say(memory.phase, memory.reason);
  }
  looked_round_ = memory.looked_round;
  trail_.restore(std::move(memory.floor));
  exploration_.restore_looks(std::move(memory.looks));
}

// ---- one frame ----

void Navigator::step(const Situation& now, const mapping::MapReplica& map,
                     const mapping::MapReplica::Changes& changes) {
  if (stepped_ && (now.epoch != now_.epoch || now.utime < now_.utime)) {
    moving_ = {};
    moving_since_ = now.utime;
    drop_target();
    rest();
  }
  if (stepped_ && now.epoch == now_.epoch) count_way_behind(now);
  now_ = now;
  if (!stepped_) map_here_by_ = now.utime + kMapComes_us;
  stepped_ = true;
  if (changes.started_over) forget_place();
  model_.take(changes);
  model_.read(map);
  track();
  expire_blocked();
  decide(std::exchange(judged_, false));
  // Judging the ground and planning on it are never done in one step.
  std::vector<BlockedSpot> blocked;
  for (const Blocked& entry : blocked_) blocked.push_back(entry.spot);
  judged_ = model_.refresh(now_.utime, trail_.floor(), blocked);
  reckon();
}

// The robot does not see what comes up behind it. People keep away from a robot that stands; so
// what it left by driving forward is free behind it, and no more than that.
void Navigator::count_way_behind(const Situation& next) {
  const Eigen::Vector2d step_m = next.in_odom.at_m - now_.in_odom.at_m;
  const double turned_rad = wrapped_rad(next.in_odom.heading_rad - now_.in_odom.heading_rad);
  behind_m_ = std::clamp(behind_m_ + step_m.dot(ahead(now_.in_odom.heading_rad)) -
                             config_.back_off_m * std::abs(turned_rad),
                         0.0, config_.back_off_m);
}

void Navigator::forget_place() {
  trail_.clear();
  blocked_.clear();
  exploration_.restore_looks({});
}

void Navigator::track() {
  if (!now_.located || now_.lost) return;
  const Eigen::Vector2d at_m = in_map().at_m;
  const bool elsewhere =
      trail_.floor().empty() || (trail_.floor().back().at_m - at_m).norm() > kJump_m;
  if (elsewhere) trail_.stand(at_m, now_.height_m);
  if (trail_.drive(at_m, now_.height_m) || elsewhere) model_.renew();
}

void Navigator::expire_blocked() {
  const auto expired =
      std::erase_if(blocked_, [&](const Blocked& entry) { return entry.until < now_.utime; });
  if (expired > 0) model_.renew();
}

void Navigator::reckon() {
  report_.distance_left_m = follower_.distance_left_m();
  report_.eta_s = report_.distance_left_m / kReckoned_mps;
}

void Navigator::decide(bool judged) {
  if (mission_ == Mission::kNone) return;
  if (now_.latched) {
    begin_progress();
    return say(report_.phase, "stopped by a person until released");
  }
  if (!now_.located) return say(Phase::kRecovering, "not told yet where it is");
  if (now_.lost) return be_lost();
  if (activity_ == Activity::kLost) rest();
  switch (activity_) {
    case Activity::kTurning:
      return go_on_turning();
    case Activity::kSettling:
      return go_on_settling();
    case Activity::kBackingOff:
      return go_on_backing_off();
    case Activity::kFollowing:
      go_on_following();
      break;
    default:
      model_.renew();
  }
  const bool plans = activity_ == Activity::kNone || activity_ == Activity::kFollowing;
  if (judged && plans && mission_ != Mission::kNone) next();
}

void Navigator::next() {
  if (mission_ == Mission::kExplore && !looked_round_) {
    say(Phase::kExploring, "looks around");
    begin_turns({2 * std::numbers::pi});
  } else if (mission_ == Mission::kExplore) {
    next_view();
  } else {
    next_way();
  }
}

void Navigator::drop_target() {
  view_.reset();
  looks_again_at_m_.reset();
}

void Navigator::next_view() {
  if (looks_again_at_m_ && activity_ == Activity::kFollowing) return mend_way();
  const GroundMap& ground = model_.ground();
  const CostGrid costs = costs_from_here();
  const RouteField routes = all_routes(costs, cell_at(in_map().at_m));
  exploration_.update(ground, routes, robot_.turning_radius_m(), config_.route.margin_m);
  if (view_ && looked_) exploration_.give_up_in_view(ground, view_->pose, 1);
  if (view_ && !looked_ && activity_ == Activity::kFollowing) {
    const double least = std::max(config_.exploration.least_m2, kResolved * view_->gain_m2);
    if (exploration_.gain_m2(ground, view_->pose) >= least) return mend_way();
  }
  view_ = exploration_.choose(ground, routes, in_map());
  looked_ = false;
  if (!view_) {
    if (!look_again(costs, routes)) explored(routes);
    return;
  }
  nothing_wanted_ = 0;
  say(Phase::kExploring, words("looks at %.1f m2 of unknown floor", view_->gain_m2));
  set_out(costs, route_to(routes, cell_at(view_->pose.at_m)),
          {view_->pose.at_m, view_->pose.heading_rad});
}

// What blocked the way is often gone soon, but guard believes it only when it sees it, and that it
// does from some way off.
bool Navigator::look_again(const CostGrid& costs, const RouteField& routes) {
  for (const Blocked& entry : blocked_) {
    const auto looks = std::count_if(looked_again_at_m_.begin(), looked_again_at_m_.end(),
                                     [&](const Eigen::Vector2d& at_m) {
                                       return (at_m - entry.spot.at_m).norm() < kSamePlace_m;
                                     });
    if (looks >= kLooksAgain) continue;
    const auto best = exploration_.see_spot(model_.ground(), routes, in_map(), entry.spot);
    if (!best) continue;
    looks_again_at_m_ = entry.spot.at_m;
    say(report_.phase, "looks again at what blocked the way");
    set_out(costs, route_to(routes, cell_at(best->pose.at_m)),
            {best->pose.at_m, best->pose.heading_rad});
    return true;
  }
  return false;
}

void Navigator::looked_again() {
  looked_again_at_m_.push_back(*looks_again_at_m_);
  std::erase_if(blocked_, [&](const Blocked& entry) {
    return (entry.spot.at_m - *looks_again_at_m_).norm() < kSamePlace_m;
  });
  looks_again_at_m_.reset();
  model_.renew();
}

void Navigator::explored(const RouteField& routes) {
  rest();
  const auto cells = std::count_if(routes.cost.begin(), routes.cost.end(),
                                   [](float cost) { return cost < kImpassable; });
  const double reach_m2 = static_cast<double>(cells) * kCell_m * kCell_m;
  if (reach_m2 < kEnclosed_m2 && recoveries_ < 2) return recover();
  if (!blocked_.empty()) return say(Phase::kExploring, "waits for a blocked way to come free");
  if (!now_.map_whole || now_.map_through < now_.utime - kMapBehind_us) {
    nothing_wanted_ = 0;
    model_.renew();
    return say(Phase::kExploring, "waits for the map");
  }
  if (++nothing_wanted_ < kSureOfNothing || now_.utime < map_here_by_) return;
  std::string reason = "nothing that can be reached is unknown any more";
  const double given_up_m2 = exploration_.given_up_m2();
  if (given_up_m2 > config_.exploration.least_m2)
    reason += words("; %.1f m2 could not be seen", given_up_m2);
  finish(Phase::kArrived, reason);
}

void Navigator::next_way() {
  if (activity_ == Activity::kFollowing) return mend_way();
  const CostGrid costs = costs_from_here();
  const Cell goal = cell_at(destination_.at_m);
  const auto route = find_route(costs, cell_at(in_map().at_m), goal);
  if (!route && now_.utime < map_here_by_) return;
  if (!route && look_again(costs, all_routes(costs, cell_at(in_map().at_m)))) return;
  if (!route) return finish(Phase::kRefused, why_not(goal, costs));
  say(Phase::kDriving, "under way");
  set_out(costs, route->cells, destination_);
}

// ---- ways ----

CostGrid Navigator::costs_from_here() const {
  CostGrid costs = model_.costs();
  open_around(model_.ground(), in_map().at_m, kEscape_m, costs);
  return costs;
}

std::string Navigator::why_not(Cell goal, const CostGrid& costs) const {
  const ColumnClass there = model_.ground().at(goal);
  if (there == ColumnClass::kUnknown) return "unknown: no floor was seen there";
  if (there == ColumnClass::kOccupied) return "occupied: something is in the way there";
  if (costs.at(goal, kImpassable) == kImpassable) {
    return words("occupied: something stands only %.2f m from there",
                 model_.ground().clearance_m(goal));
  }
  return "unreachable: no way leads there";
}

void Navigator::set_out(const CostGrid& costs, const std::vector<Cell>& route,
                        const Destination& to) {
  way_to_ = to;
  planned_T_map_odom_ = now_.T_map_odom;
  const Pose2 here = in_map();
  if (route.size() < 2 || (to.at_m - here.at_m).norm() < kHere_m) {
    const double turn_rad = to.heading_rad ? wrapped_rad(*to.heading_rad - here.heading_rad) : 0;
    return begin_turns({turn_rad});
  }
  std::vector<Eigen::Vector2d> points = smooth_path(costs, route);
  points.front() = here.at_m;
  points.back() = to.at_m;
  const Pose2 T_odom_map = inverse(now_.T_map_odom);
  const double limit_m = robot_.turning_radius_m() + config_.route.margin_m;
  PlannedPath path;
  for (const Eigen::Vector2d& point : points) {
    const double room_m = std::max(0.0, model_.ground().clearance_m(cell_at(point)) - limit_m);
    const double speed_mps = std::min(robot_.max_speed_mps, kSlowest_mps + kSpeedPerRoom * room_m);
    path.points.push_back({moved(T_odom_map, {point, 0}).at_m, speed_mps, room_m});
  }
  if (to.heading_rad) path.heading_rad = wrapped_rad(*to.heading_rad + T_odom_map.heading_rad);
  const bool mended = activity_ == Activity::kFollowing;
  follower_.follow(std::move(path));
  ++path_count_;
  activity_ = Activity::kFollowing;
  if (!mended) begin_progress();
  const double length_m = follower_.distance_left_m();
  give_up_at_ = now_.utime + static_cast<std::int64_t>(1e6 * (30 + length_m / 0.05));
}

bool Navigator::way_is_good() const {
  const Eigen::Vector2d shift = now_.T_map_odom.at_m - planned_T_map_odom_.at_m;
  const double turned_rad =
      wrapped_rad(now_.T_map_odom.heading_rad - planned_T_map_odom_.heading_rad);
  if (shift.norm() > kShift_m || std::abs(turned_rad) > kShift_rad) return false;
  const double limit_m = robot_.turning_radius_m() + config_.route.margin_m - kNoise_m;
  const auto& points = follower_.path().points;
  const Eigen::Vector2d here = in_map().at_m;
  for (std::size_t i = follower_.nearest(); i < points.size(); ++i) {
    const Eigen::Vector2d at_m = moved(now_.T_map_odom, {points[i].at_m, 0}).at_m;
    const Cell cell = cell_at(at_m);
    if (model_.ground().at(cell) == ColumnClass::kOccupied) return false;
    if ((at_m - here).norm() > kEscape_m && model_.ground().clearance_m(cell) < limit_m)
      return false;
  }
  return true;
}

void Navigator::mend_way() {
  if (activity_ != Activity::kFollowing || way_is_good()) return;
  const CostGrid costs = costs_from_here();
  const auto route = find_route(costs, cell_at(in_map().at_m), cell_at(way_to_.at_m));
  if (route) return set_out(costs, route->cells, way_to_);
  drop_target();
  rest();
}

// ---- motion ----

// Where its corners may touch something as it turns on the spot, the robot turns so slowly that
// this does no harm. Lost, it knows of what stood round it when it was not.
double Navigator::safe_turn_radps() const {
  const Eigen::Vector2d at_m =
      now_.lost && !trail_.floor().empty() ? trail_.floor().back().at_m : in_map().at_m;
  const bool room =
      model_.ground().clearance_m(cell_at(at_m)) > robot_.turning_radius_m() + kRoomToTurn_m;
  return room ? config_.follower.turn_radps : kGentle_mps / robot_.turning_radius_m();
}

Drive Navigator::drive(Utime now) {
  const std::int64_t age_us = now - now_.utime;
  if (!stepped_ || age_us > kStale_us || age_us < 0 || now_.latched || !now_.located) {
    moving_ = {};
    moving_since_ = now;
    return moving_;
  }
  const double dt_s = std::clamp(to_seconds(now - moving_since_), 0.0, 0.2);
  moving_since_ = now;
  const double ahead_s = to_seconds(std::min(age_us, kCarryPose_us));
  const double turned_rad = now_.turn_radps * ahead_s;
  Pose2 pose = now_.in_odom;
  pose.at_m += now_.forward_mps * ahead_s * ahead(pose.heading_rad + turned_rad / 2);
  pose.heading_rad = wrapped_rad(pose.heading_rad + turned_rad);
  const double turn_radps = safe_turn_radps();
  switch (activity_) {
    case Activity::kFollowing:
      return moving_ = follower_.step(pose, moving_, dt_s, {now_.allowed_mps, turn_radps});
    case Activity::kTurning:
      return moving_ = follower_.turn(turns_rad_.back() - turned_rad, moving_, dt_s, turn_radps);
    case Activity::kLost:
      return moving_ = turns_rad_.empty()
                           ? follower_.halt(moving_, dt_s)
                           : follower_.turn(turns_rad_.back(), moving_, dt_s, turn_radps);
    case Activity::kBackingOff: {
      const Eigen::Vector2d back_m =
          moved(inverse(moved(now_.T_map_odom, pose)), {way_back_m_.back(), 0}).at_m;
      const double curvature = 2 * back_m.y() / back_m.squaredNorm();
      moving_.forward_mps = -config_.back_off_mps;
      moving_.turn_radps =
          std::clamp(-config_.back_off_mps * curvature, -kBackTurn_radps, kBackTurn_radps);
      return moving_;
    }
    default:
      return moving_ = follower_.halt(moving_, dt_s);
  }
}

}  // namespace cairn::planning
