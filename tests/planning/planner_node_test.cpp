// SPDX-License-Identifier: Apache-2.0
#include "procs/planner/planner_node.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "made_ground.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/map_messages.hpp"
#include "node_bench.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;

constexpr std::int64_t kTick_us = 10'000;
constexpr std::int64_t kFrame_us = 70'000;
constexpr std::int64_t kDigest_us = 15 * kFrame_us;
constexpr std::int64_t kClearance_us = 50'000;

/// planner on a bus with somebody who plays odometry, localizer, mapper, guard and the tracks. The
/// map is a floor of 4 x 4 m with a wall at x = 1.2 m.
class PlannerNodeTest : public testing::NodeBench {
 protected:
  PlannerNodeTest() {
    peer_.on<channels::DriveCommand>([this](const drive_command_t& heard) {
      commands_.push_back(heard);
      moving_ = {heard.forward_mps, heard.turn_radps};
    });
    peer_.on<channels::PlanState>([this](const plan_state_t& heard) { states_.push_back(heard); });
    peer_.on<channels::Path>([this](const path_t& heard) { paths_.push_back(heard); });
    clock_.set(now_);
  }

  void start(bool explore, StateFolder state = {}) {
    planner_.reset();
    PlannerConfig config;
    config.explore_at_start = explore;
    start_node("planner", std::move(state));
    planner_ = std::move(PlannerNode::create(config, *node_).value());
  }

  /// What mapper knows; `all` of it, or every second brick.
  void send_map(bool all = true) {
    testing::MadeMap made(0.04);
    made.floor(-2, 2, [](double, double) { return 0.0; });
    made.fill({1.2, -2.8, 0}, {1.3, 2.8, 0.5});
    mappers_ = {};
    const auto bricks = made.send(mappers_);
    mapping::MapDelta delta{5, now_, 0.04, {}};
    for (std::size_t i = 0; i < bricks.size(); i += all ? 1 : 2)
      delta.bricks.push_back(mapping::classes_of(mappers_, bricks[i]));
    send(delta);
    mapper_runs_ = true;
  }

  void send(const mapping::MapDelta& delta) {
    const auto messages = messages::to_messages(delta, messages::DeltaKind::kChanges).value();
    for (const map_delta_t& message : messages) {
      peer_.publish<channels::MapDelta>(message, now_);
    }
  }

  void send_digest() {
    messages::MapDigest digest{5, 0.04, now_, {}};
    for (const auto& [tile, state] : mappers_.tile_states())
      digest.tiles.push_back({tile, state.hash});
    for (const map_digest_t& page : messages::to_messages(digest, now_))
      peer_.publish<channels::MapDigest>(page, now_);
  }

  void send_frame() {
    Isometry T = Isometry::Identity();
    T.linear() = rotation_from_rpy(0, 0, at_.heading_rad);
    T.translation().head<2>() = at_.at_m;
    odometry_t odometry{};
    odometry.T_odom_body = messages::to_message(T);
    odometry.twist = messages::to_message(
        messages::Twist{{moving_.forward_mps, 0, 0}, {0, 0, moving_.turn_radps}});
    odometry.quality = 1;
    peer_.publish<channels::Odometry>(odometry, now_);
    pose_t pose{};
    pose.T_map_body = odometry.T_odom_body;
    pose.T_map_odom = messages::to_message(Isometry::Identity());
    pose.state = pose_state_;
    peer_.publish<channels::Pose>(pose, now_);
  }

  /// Data time and host time go on by `seconds`.
  void run(double seconds) {
    for (const Utime until = now_ + static_cast<Utime>(1e6 * seconds); now_ < until;) {
      now_ += kTick_us;
      clock_.set(now_);
      send_clock(now_);
      const double dt_s = to_seconds(kTick_us);
      at_.heading_rad = planning::wrapped_rad(at_.heading_rad + moving_.turn_radps * dt_s);
      at_.at_m += moving_.forward_mps * dt_s * planning::ahead(at_.heading_rad);
      if (frames_on_ && now_ % kFrame_us == 0) send_frame();
      if (mapper_runs_ && now_ % kFrame_us == 0) send({5, now_, 0.04, {}});
      if (mapper_runs_ && now_ % kDigest_us == 0) send_digest();
      if (now_ % kClearance_us == 0) {
        clearance_t clearance{};
        clearance.max_forward_mps = allowed_mps_;
        clearance.reason = "test";
        peer_.publish<channels::Clearance>(clearance, now_);
        wheel_state_t wheels{};
        wheels.ticks_per_m = 5000;
        wheels.gate = gate_;
        peer_.publish<channels::WheelState>(wheels, now_);
      }
      spin();
    }
  }

  void ask(std::int8_t action, double x_m = 0, double y_m = 0) {
    goal_t goal{};
    goal.goal_id = ++goal_id_;
    goal.action = action;
    goal.x_m = x_m;
    goal.y_m = y_m;
    peer_.publish<channels::Goal>(goal, now_);
  }

  [[nodiscard]] bool moves() const { return moving_.forward_mps != 0 || moving_.turn_radps != 0; }

  std::unique_ptr<PlannerNode> planner_;
  std::vector<drive_command_t> commands_;
  std::vector<plan_state_t> states_;
  std::vector<path_t> paths_;
  planning::Pose2 at_;
  planning::Drive moving_;
  double allowed_mps_ = 0.5;
  std::int8_t pose_state_ = pose_t::STATE_TRACKING;
  std::int8_t gate_ = wheel_state_t::GATE_DRIVING;
  std::int64_t goal_id_ = 0;
  Utime now_ = 1'000'000;
  bool frames_on_ = true;
  bool mapper_runs_ = false;
  mapping::MapReplica mappers_;
};

TEST_F(PlannerNodeTest, WithNothingToDoItSaysSoAndCommandsNothing) {
  start(false);
  send_map();
  run(3);
  EXPECT_TRUE(commands_.empty());
  ASSERT_FALSE(states_.empty());
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_IDLE);
  EXPECT_GE(states_.size(), 2U);
}

TEST_F(PlannerNodeTest, DrivesToAGoalAndSaysWhenItIsThere) {
  start(false);
  send_map();
  run(1);
  ask(goal_t::ACTION_GO, -1.2, 0.8);
  run(25);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_ARRIVED) << states_.back().reason;
  EXPECT_EQ(states_.back().goal_id, 1);
  EXPECT_LT((at_.at_m - Eigen::Vector2d(-1.2, 0.8)).norm(), 0.1);
  ASSERT_GE(paths_.size(), 2U);
  EXPECT_GT(paths_.front().count, 5);
  EXPECT_EQ(paths_.back().count, 0) << "no path any more";
  for (std::size_t i = 1; i < commands_.size(); ++i) {
    EXPECT_LE(commands_[i].header.sent_steady_us - commands_[i - 1].header.sent_steady_us, 100'000);
    EXPECT_LE(commands_[i].forward_mps, 0.5);
    EXPECT_LE(std::abs(commands_[i].turn_radps), 1.0);
  }
  EXPECT_LT(commands_.back().header.sent_steady_us, now_ - 2'000'000) << "idle again, it is silent";
  EXPECT_EQ(commands_.back().forward_mps, 0);
}

TEST_F(PlannerNodeTest, RefusedGoalsSayWhy) {
  start(false);
  send_map();
  run(1);
  run(6);
  const auto answer = [&](double x_m, double y_m) {
    ask(goal_t::ACTION_GO, x_m, y_m);
    run(1);
    EXPECT_EQ(states_.back().state, plan_state_t::STATE_REFUSED);
    EXPECT_EQ(states_.back().goal_id, goal_id_);
    return states_.back().reason;
  };
  EXPECT_EQ(answer(1.25, 0).rfind("occupied: something is in the way", 0), 0U);
  EXPECT_EQ(answer(1.05, 0).rfind("occupied: something stands only", 0), 0U);
  EXPECT_EQ(answer(1.7, 0).rfind("unknown", 0), 0U);
  EXPECT_EQ(answer(500, 500).rfind("unknown", 0), 0U);
  EXPECT_FALSE(moves());
}

TEST_F(PlannerNodeTest, CancelledItStops) {
  start(false);
  send_map();
  run(1);
  ask(goal_t::ACTION_GO, -1.5, 1.5);
  run(3);
  EXPECT_TRUE(moves());
  ask(goal_t::ACTION_CANCEL);
  run(1);
  EXPECT_FALSE(moves());
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_IDLE);
}

TEST_F(PlannerNodeTest, WithoutFreshOdometryItCommandsZero) {
  start(true);
  send_map();
  run(2);
  EXPECT_TRUE(moves());
  frames_on_ = false;
  run(0.45);
  const std::size_t before = commands_.size();
  run(0.5);
  EXPECT_GT(commands_.size(), before + 4) << "zero is said, not left unsaid";
  for (std::size_t i = before; i < commands_.size(); ++i) {
    EXPECT_EQ(commands_[i].forward_mps, 0);
    EXPECT_EQ(commands_[i].turn_radps, 0);
  }
  frames_on_ = true;
  run(1);
  EXPECT_TRUE(moves());
}

TEST_F(PlannerNodeTest, WithoutPermissionItDoesNotGoForward) {
  start(false);
  send_map();
  run(1);
  allowed_mps_ = 0;
  ask(goal_t::ACTION_GO, 0.8, 0);
  run(3);
  for (const drive_command_t& command : commands_) EXPECT_LE(command.forward_mps, 0);
  run(60);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_REFUSED) << states_.back().reason;
}

TEST_F(PlannerNodeTest, LatchedItWaitsAndSaysSo) {
  start(true);
  send_map();
  gate_ = wheel_state_t::GATE_LATCHED;
  run(3);
  EXPECT_FALSE(moves());
  EXPECT_EQ(states_.back().reason, "stopped by a person until released");
  gate_ = wheel_state_t::GATE_IDLE;
  run(1);
  EXPECT_TRUE(moves());
}

TEST_F(PlannerNodeTest, LostItTurnsOnTheSpotAndFoundItGoesOn) {
  start(false);
  send_map();
  run(1);
  ask(goal_t::ACTION_GO, -1.5, -1.5);
  run(3);
  pose_state_ = pose_t::STATE_LOST;
  run(3);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_RECOVERING);
  EXPECT_EQ(states_.back().reason.rfind("lost: turns", 0), 0U) << states_.back().reason;
  EXPECT_NE(moving_.turn_radps, 0);
  EXPECT_EQ(moving_.forward_mps, 0);
  pose_state_ = pose_t::STATE_TRACKING;
  run(30);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_ARRIVED) << states_.back().reason;
}

TEST_F(PlannerNodeTest, KilledItGoesOnWithItsGoal) {
  const testing::TemporaryFolder folder;
  start(false, StateFolder::open(folder.path()).value());
  send_map();
  run(1);
  ask(goal_t::ACTION_GO, -1.5, 1.5);
  run(2.5);
  node_.reset();
  planner_.reset();
  start(false, StateFolder::open(folder.path()).value());
  send_map();
  run(30);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_ARRIVED) << states_.back().reason;
  EXPECT_EQ(states_.back().goal_id, 1);
}

// A planner that was killed knows at first what changed since, and no more than that.
TEST_F(PlannerNodeTest, ExplorationDoesNotEndOnAPartOfTheMap) {
  start(true);
  send_map(false);
  run(120);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_EXPLORING) << states_.back().reason;
  EXPECT_EQ(states_.back().reason, "waits for the map");
  send_map();
  run(60);
  EXPECT_EQ(states_.back().state, plan_state_t::STATE_ARRIVED) << states_.back().reason;
}

// Nor is anything given up as looked at in vain that a mapper which is away cannot show.
TEST_F(PlannerNodeTest, NothingIsGivenUpWhileMapperIsAway) {
  start(true);
  send_map();
  mapper_runs_ = false;
  run(60);
  EXPECT_TRUE(planner_->navigator().memory().looks.empty());
  EXPECT_NE(states_.back().state, plan_state_t::STATE_ARRIVED) << states_.back().reason;
}

TEST_F(PlannerNodeTest, BadMessagesAreRefusedCountedAndHarmless) {
  start(true);
  send_map();
  run(1);
  goal_t goal{};
  goal.action = 9;
  peer_.publish<channels::Goal>(goal, now_);
  goal.action = goal_t::ACTION_GO;
  goal.x_m = std::numeric_limits<double>::quiet_NaN();
  peer_.publish<channels::Goal>(goal, now_);
  odometry_t odometry{};
  odometry.quality = 5;
  peer_.publish<channels::Odometry>(odometry, now_);
  pose_t pose{};
  peer_.publish<channels::Pose>(pose, now_);
  clearance_t clearance{};
  clearance.max_forward_mps = -1;
  peer_.publish<channels::Clearance>(clearance, now_);
  map_delta_t delta{};
  delta.resolution_m = -1;
  peer_.publish<channels::MapDelta>(delta, now_);
  map_digest_t digest{};
  digest.page = 4;
  peer_.publish<channels::MapDigest>(digest, now_);
  wheel_state_t wheels{};
  peer_.publish<channels::WheelState>(wheels, now_);
  run(1);
  const auto refused = [&](const char* channel) {
    return node_->counts().find(channel)->second.refused;
  };
  EXPECT_EQ(refused(channels::Goal::name), 2);
  EXPECT_EQ(refused(channels::Odometry::name), 1);
  EXPECT_EQ(refused(channels::Pose::name), 1);
  EXPECT_EQ(refused(channels::Clearance::name), 1);
  EXPECT_EQ(refused(channels::MapDelta::name), 1);
  EXPECT_EQ(refused(channels::MapDigest::name), 1);
  EXPECT_EQ(refused(channels::WheelState::name), 1);
  EXPECT_TRUE(moves());
}

}  // namespace
}  // namespace cairn
