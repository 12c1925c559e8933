// SPDX-License-Identifier: Apache-2.0
#include "procs/planner/planner_node.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "messages/check.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr const char* kCheckpoint = "planner";
constexpr std::int64_t kCommandPeriod_us = 50'000;
constexpr std::int64_t kCheckpointPeriod_us = kMicrosecondsPerSecond;
constexpr std::int64_t kClearanceHolds_us = 200'000;
constexpr std::int64_t kOdometryHolds_us = kMicrosecondsPerSecond;  // host time
constexpr std::int64_t kZerosAtRest_us = kMicrosecondsPerSecond;
constexpr std::int64_t kUnsure_us = kMicrosecondsPerSecond;

RobotConfig limited(RobotConfig robot, const PlannerConfig& config) {
  robot.max_speed_mps = std::min(robot.max_speed_mps, config.max_speed_mps);
  robot.max_turn_radps = std::min(robot.max_turn_radps, config.max_turn_radps);
  return robot;
}

bool same(const planning::PlanReport& a, const planning::PlanReport& b) {
  return a.phase == b.phase && a.goal_id == b.goal_id && a.reason == b.reason;
}

}  // namespace

Result<std::unique_ptr<PlannerNode>> PlannerNode::create(const Config& config, bus::Node& node) {
  return std::make_unique<PlannerNode>(config, node);
}

PlannerNode::PlannerNode(const Config& config, bus::Node& node)
    : config_{config}, node_{node}, navigator_{config.navigation, limited(config.robot, config)} {
  resume();
  node.on<channels::Odometry>([this](const odometry_t& odometry) { take(odometry); });
  node.on<channels::Pose>([this](const pose_t& pose) { take(pose); });
  node.on<channels::WheelState>([this](const wheel_state_t& wheels) { take(wheels); });
  node.on<channels::Clearance>([this](const clearance_t& clearance) { take(clearance); });
  node.on<channels::Goal>([this](const goal_t& goal) { take(goal); });
  node.on<channels::MapDelta>([this](const map_delta_t& delta) {
    if (auto put = map_.put(delta); !put)
      node_.refuse(channels::MapDelta::name, put.error().message);
  });
  node.on<channels::MapDigest>([this](const map_digest_t& digest) {
    if (auto put = map_.put(digest); !put)
      node_.refuse(channels::MapDigest::name, put.error().message);
  });
  node.every_host(kCommandPeriod_us, [this] { command_if_due(); });
  node.every_data(kMicrosecondsPerSecond, [this] { tell_state(); });
  if (node.state().enabled()) {
    node.every_host(kCheckpointPeriod_us, [this] {
      if (auto kept = remember(); !kept) node_.log(bus::Level::kWarning, kept.error().message);
    });
  }
}

// ---- what comes in ----

void PlannerNode::take(const odometry_t& odometry) {
  if (auto good = messages::check(odometry); !good)
    return node_.refuse(channels::Odometry::name, good.error().message);
  odometry_utime_ = odometry.header.utime;
  odometry_came_us_ = node_.host_time();
  map_.note_frame(odometry_utime_);
  map_.apply_for_frame(odometry_utime_);
  node_.counter("map_late") = map_.late();
  navigator_.step(situation(odometry), map_.map(), map_.take_changes());
  command();
  tell_path();
  tell_state_if_new();
  ask_for_map();
}

void PlannerNode::take(const pose_t& pose) {
  if (auto good = messages::check(pose); !good)
    return node_.refuse(channels::Pose::name, good.error().message);
  if (pose.state == pose_t::STATE_TRACKING) sure_utime_ = pose.header.utime;
  if (!pose_ || pose.epoch != pose_->epoch) sure_utime_ = pose.header.utime;
  pose_ = pose;
}

void PlannerNode::take(const wheel_state_t& wheels) {
  if (auto good = messages::check(wheels); !good)
    return node_.refuse(channels::WheelState::name, good.error().message);
  latched_ = wheels.gate == wheel_state_t::GATE_LATCHED;
}

void PlannerNode::take(const clearance_t& clearance) {
  if (auto good = messages::check(clearance); !good)
    return node_.refuse(channels::Clearance::name, good.error().message);
  clearance_ = clearance;
}

void PlannerNode::take(const goal_t& goal) {
  if (auto good = messages::check(goal); !good)
    return node_.refuse(channels::Goal::name, good.error().message);
  switch (goal.action) {
    case goal_t::ACTION_EXPLORE:
      navigator_.explore(goal.goal_id);
      break;
    case goal_t::ACTION_CANCEL:
      navigator_.cancel(goal.goal_id);
      break;
    default: {
      planning::Destination destination{{goal.x_m, goal.y_m}, {}};
      if (goal.has_heading) destination.heading_rad = planning::wrapped_rad(goal.heading_rad);
      navigator_.go(goal.goal_id, destination);
    }
  }
  tell_path();
  tell_state_if_new();
}

// The last word on the map's place under the odometry frame counts, also when localizer is silent.
planning::Situation PlannerNode::situation(const odometry_t& odometry) const {
  planning::Situation now;
  const Isometry T_odom_body = *messages::to_isometry(odometry.T_odom_body, "T_odom_body");
  now.utime = odometry.header.utime;
  now.in_odom = planning::from_above(T_odom_body);
  now.forward_mps = odometry.twist.linear_mps[0];
  now.turn_radps = odometry.twist.angular_radps[2];
  now.epoch = odometry.epoch;
  now.height_m = T_odom_body.translation().z();
  if (pose_ && pose_->epoch == odometry.epoch) {
    const Isometry T_map_odom = *messages::to_isometry(pose_->T_map_odom, "T_map_odom");
    now.located = true;
    now.T_map_odom = planning::from_above(T_map_odom);
    now.height_m = (T_map_odom * T_odom_body).translation().z();
    now.lost = lost();
  }
  const bool fresh =
      clearance_ && node_.host_time() - clearance_->header.sent_steady_us <= kClearanceHolds_us;
  now.allowed_mps = fresh ? clearance_->max_forward_mps : 0;
  now.latched = latched_;
  now.map_through = map_.map().utime();
  now.map_whole = map_.whole();
  return now;
}

bool PlannerNode::lost() const {
  return pose_->state != pose_t::STATE_TRACKING && pose_->header.utime - sure_utime_ > kUnsure_us;
}

// ---- what goes out ----

void PlannerNode::ask_for_map() {
  Eigen::Vector3d near_m = Eigen::Vector3d::Zero();
  if (pose_) near_m = Eigen::Map<const Eigen::Vector3d>(pose_->T_map_body.position_m);
  auto request = map_.next_request(node_.host_time(), node_.data_time(), near_m);
  if (request) node_.publish<channels::MapRequest>(std::move(*request), node_.data_time());
}

void PlannerNode::command() {
  const HostTime host_us = node_.host_time();
  const Utime now = std::max(node_.data_time(), odometry_utime_);
  planning::Drive drive = navigator_.drive(now);
  if (odometry_came_us_ == 0 || host_us - odometry_came_us_ > kOdometryHolds_us) drive = {};
  const bool moves = drive.forward_mps != 0 || drive.turn_radps != 0;
  if (moves || !navigator_.idle()) moved_us_ = host_us;
  // With nothing to do, motor is told to stand, and then left alone.
  if (moved_us_ == 0 || host_us - moved_us_ > kZerosAtRest_us) return;
  drive_command_t message{};
  message.source = drive_command_t::SOURCE_PLANNER;
  message.forward_mps = drive.forward_mps;
  message.turn_radps = drive.turn_radps;
  node_.publish<channels::DriveCommand>(message, now);
  commanded_us_ = host_us;
}

void PlannerNode::command_if_due() {
  if (node_.host_time() - commanded_us_ >= kCommandPeriod_us) command();
}

void PlannerNode::tell_path() {
  if (navigator_.path_count() == paths_told_) return;
  paths_told_ = navigator_.path_count();
  const planning::PlannedPath& path = navigator_.path();
  path_t message{};
  message.goal_id = navigator_.report().goal_id;
  message.epoch = pose_ ? pose_->epoch : 0;
  message.count = static_cast<std::int32_t>(path.points.size());
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const std::size_t next = std::min(i + 1, path.points.size() - 1);
    const Eigen::Vector2d way = path.points[next].at_m - path.points[next > 0 ? next - 1 : 0].at_m;
    const bool end = next == i && path.heading_rad.has_value();
    message.x_m.push_back(static_cast<float>(path.points[i].at_m.x()));
    message.y_m.push_back(static_cast<float>(path.points[i].at_m.y()));
    message.heading_rad.push_back(
        static_cast<float>(end ? *path.heading_rad : std::atan2(way.y(), way.x())));
    message.speed_mps.push_back(static_cast<float>(path.points[i].speed_mps));
  }
  node_.publish<channels::Path>(std::move(message), odometry_utime_);
}

void PlannerNode::tell_state() {
  told_ = navigator_.report();
  plan_state_t message{};
  message.goal_id = told_.goal_id;
  message.state = static_cast<std::int8_t>(told_.phase);
  message.reason = told_.reason;
  message.distance_left_m = told_.distance_left_m;
  message.eta_s = told_.eta_s;
  node_.publish<channels::PlanState>(std::move(message), node_.data_time());
}

void PlannerNode::tell_state_if_new() {
  if (!same(told_, navigator_.report())) tell_state();
}

// ---- over a restart ----

void PlannerNode::resume() {
  const auto bytes = node_.state().load(kCheckpoint);
  if (bytes) {
    auto memory = planning::plan_memory_from_bytes(*bytes);
    if (memory) {
      navigator_.restore(std::move(*memory));
      return node_.log(bus::Level::kInfo, "goes on with what it was doing");
    }
    node_.log(bus::Level::kWarning, "the checkpoint is not used: " + memory.error().message);
  }
  if (config_.explore_at_start) navigator_.explore(0);
}

Result<void> PlannerNode::remember() {
  auto bytes = planning::to_bytes(navigator_.memory());
  if (bytes == remembered_) return {};
  auto saved = node_.state().save(kCheckpoint, bytes);
  if (saved) remembered_ = std::move(bytes);
  return saved;
}

Result<void> PlannerNode::finish() { return node_.state().enabled() ? remember() : Result<void>{}; }

}  // namespace cairn
