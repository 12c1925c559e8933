// SPDX-License-Identifier: Apache-2.0
#include "procs/motor/motor_node.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/lockstep.hpp"
#include "motor/memory_link.hpp"
#include "node_bench.hpp"
#include "temporary_folder.hpp"
#include "wheel_rig.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;
namespace fs = std::filesystem;

constexpr std::int64_t kMs = 1000;
constexpr HostTime kStart_us = 50'000'000;
constexpr Utime kData_us = 3'000'000'000;

/// motor on a bus with somebody who plays the clock, planner, guard and people, and a controller
/// with two tracks at the end of its line; host time goes on by a millisecond at a time.
class MotorNodeTest : public testing::NodeBench {
 protected:
  MotorNodeTest() {
    clock_.set(kStart_us);
    peer_.on<channels::WheelState>([this](const wheel_state_t& heard) { wheels_ = heard; });
    peer_.on<channels::ProcessStatus>([this](const process_status_t& heard) {
      if (heard.process == "motor") status_ = heard;
    });
    peer_.on<channels::LogLine>([this](const log_line_t& heard) { log_.push_back(heard.text); });
    config_.latch_file = (folder_.path() / "state" / "latch").string();
  }

  void start() {
    motor_.reset();
    start_node("motor");
    auto [far, near] = motor::make_memory_links();
    rig_.emplace(std::move(far), static_cast<std::uint32_t>(session_), clock_.now_us());
    auto created = MotorNode::create(config_, *node_, motor::open_once(std::move(near)));
    ASSERT_TRUE(created) << created.error().message;
    motor_ = std::move(*created);
  }

  Utime data_now() const { return kData_us + (clock_.now_us() - kStart_us); }

  void pass(std::int64_t duration_us) {
    for (const HostTime until_us = clock_.now_us() + duration_us; clock_.now_us() < until_us;) {
      clock_.set(clock_.now_us() + kMs);
      const std::int64_t since_us = clock_.now_us() - kStart_us;
      if (tick_ && since_us % (50 * kMs) == 0) send_clock(data_now());
      if (guard_ && since_us % (50 * kMs) == 7 * kMs) clear(0.5, "free");
      if (planner_ && since_us % (100 * kMs) == 13 * kMs) drive(0.3);
      rig_->run(clock_.now_us());
      spin();
    }
  }

  void clear(double max_forward_mps, const std::string& reason) {
    clearance_t message{};
    message.max_forward_mps = max_forward_mps;
    message.reason = reason;
    message.disparity_utime = data_now() - 60 * kMs;
    peer_.publish<channels::Clearance>(message, data_now());
  }
  void drive(double forward_mps, double turn_radps = 0,
             std::int8_t source = drive_command_t::SOURCE_PLANNER) {
    drive_command_t message{};
    message.source = source;
    message.forward_mps = forward_mps;
    message.turn_radps = turn_radps;
    peer_.publish<channels::DriveCommand>(message, data_now());
  }
  void say(std::int8_t action, bool person = true) {
    stop_t message{};
    message.action = action;
    message.person = person ? 1 : 0;
    message.who = "anna\x1b[2J";
    peer_.publish<channels::Stop>(message, data_now());
  }

  std::map<std::string, std::int64_t> counters() {
    pass(1100 * kMs);
    std::map<std::string, std::int64_t> counters;
    for (const counter_t& counter : status_.counters) counters[counter.name] = counter.value;
    return counters;
  }
  std::string why() {
    pass(1100 * kMs);
    return status_.reason;
  }
  bool was_logged(const std::string& words) const {
    for (const std::string& line : log_) {
      if (line.find(words) != std::string::npos) return true;
    }
    return false;
  }

  testing::TemporaryFolder folder_;
  MotorConfig config_;
  std::optional<testing::WheelRig> rig_;
  std::unique_ptr<MotorNode> motor_;
  bool tick_ = true;
  bool guard_ = true;
  bool planner_ = false;
  wheel_state_t wheels_{};
  process_status_t status_{};
  std::vector<std::string> log_;
};

TEST_F(MotorNodeTest, DrivesWhenToldAndPublishesWhatTheWheelsDo) {
  start();
  planner_ = true;
  pass(2000 * kMs);
  EXPECT_NEAR(rig_->left.speed_mps, 0.3, 0.01);
  EXPECT_EQ(wheels_.gate, wheel_state_t::GATE_DRIVING);
  EXPECT_EQ(wheels_.faults, 0);
  EXPECT_EQ(wheels_.ticks_per_m, 5000);
  EXPECT_NEAR(wheels_.left_measured_mps, 0.3, 0.01);
  EXPECT_NEAR(static_cast<double>(data_now() - wheels_.header.utime), 10 * kMs, 15 * kMs);
  EXPECT_EQ(status_.health, process_status_t::HEALTH_OK);
  EXPECT_EQ(status_.reason, "");
  EXPECT_TRUE(was_logged("drives"));
}

TEST_F(MotorNodeTest, HazardM17_BadCommandsAreRefusedCountedByReasonAndSaid) {
  start();
  pass(500 * kMs);
  const auto send = [&](double forward, std::int64_t age_us, std::int32_t sequence,
                        std::int8_t source, std::int64_t lease = 0) {
    drive_command_t message{};
    message.header.sent_steady_us = clock_.now_us() - age_us;
    message.header.session = 5;
    message.header.sequence = sequence;
    message.source = source;
    message.lease = lease;
    message.forward_mps = forward;
    bus::Bus& stranger = hub_.make_endpoint();
    ASSERT_TRUE(stranger.publish(channels::DriveCommand::name, bus::encode(message).value()));
    pass(5 * kMs);
    EXPECT_FALSE(rig_->driven());
  };
  send(0.3, 251 * kMs, 1, drive_command_t::SOURCE_PLANNER);
  send(0.3, 3'600'000 * kMs, 1, drive_command_t::SOURCE_PLANNER);
  send(0.3, -100 * kMs, 1, drive_command_t::SOURCE_PLANNER);
  send(std::nan(""), 0, 2, drive_command_t::SOURCE_PLANNER);
  send(-std::numeric_limits<double>::infinity(), 0, 2, drive_command_t::SOURCE_PLANNER);
  send(0.6, 0, 3, drive_command_t::SOURCE_PLANNER);
  send(0.3, 0, 3, 17);
  send(0.3, 0, 4, drive_command_t::SOURCE_PERSON);
  send(0, 0, 9, drive_command_t::SOURCE_PLANNER);
  send(0.3, 0, 9, drive_command_t::SOURCE_PLANNER);
  bus::Bus& stranger = hub_.make_endpoint();
  ASSERT_TRUE(stranger.publish(channels::DriveCommand::name, std::vector<std::uint8_t>(40, 7)));
  const auto counted = counters();
  EXPECT_EQ(counted.at("command_stale"), 2);
  EXPECT_EQ(counted.at("command_future"), 1);
  EXPECT_EQ(counted.at("command_not_finite"), 2);
  EXPECT_EQ(counted.at("command_too_fast"), 1);
  EXPECT_EQ(counted.at("command_malformed"), 1);
  EXPECT_EQ(counted.at("command_lease"), 1);
  EXPECT_EQ(counted.at("command_replayed"), 1);
  for (const channel_status_t& channel : status_.channels) {
    if (channel.channel == "DRIVE_COMMAND") {
      EXPECT_EQ(channel.refused, 10);
    }
  }
  EXPECT_TRUE(was_logged("DRIVE_COMMAND: refused"));
}

TEST_F(MotorNodeTest, HazardM18_LatchedIsSaidOnlyOnceARestartWouldFindItSo) {
  start();
  planner_ = true;
  pass(1000 * kMs);
  ASSERT_TRUE(rig_->driven());
  say(stop_t::ACTION_STOP, false);
  while (wheels_.gate != wheel_state_t::GATE_LATCHED) pass(kMs);
  EXPECT_TRUE(motor::LatchFile(config_.latch_file).load().latched);
  EXPECT_FALSE(rig_->driven());
  EXPECT_EQ(why(), "latched: STOP by anna?[2J; a person must release it (cairn release)");
  EXPECT_TRUE(was_logged("STOP by anna?[2J"));
}

TEST_F(MotorNodeTest, HazardM18_WithoutAPlaceForTheLatchItStandsAndDoesNotSayLatched) {
  std::ofstream(folder_.path() / "state") << "in the way";
  start();
  planner_ = true;
  pass(1000 * kMs);
  ASSERT_TRUE(rig_->driven());
  say(stop_t::ACTION_STOP);
  pass(20 * kMs);
  EXPECT_FALSE(rig_->driven());
  for (int i = 0; i < 100; ++i) {
    pass(30 * kMs);
    ASSERT_FALSE(rig_->driven());
    ASSERT_NE(wheels_.gate, wheel_state_t::GATE_LATCHED);
  }
  EXPECT_NE(why().find("not safe over a restart"), std::string::npos) << status_.reason;
  EXPECT_EQ(status_.health, process_status_t::HEALTH_ILL);
  fs::remove(folder_.path() / "state");
  pass(1100 * kMs);
  EXPECT_EQ(why(), "latched: STOP by anna?[2J; a person must release it (cairn release)");
  EXPECT_EQ(wheels_.gate, wheel_state_t::GATE_LATCHED);
  EXPECT_EQ(status_.health, process_status_t::HEALTH_OK);
}

TEST_F(MotorNodeTest, HazardM08_StaysLatchedOverRestartsUntilAPersonReleases) {
  start();
  planner_ = true;
  pass(500 * kMs);
  say(stop_t::ACTION_STOP);
  pass(20 * kMs);
  for (int restart = 0; restart < 5; ++restart) {
    start();
    pass(500 * kMs);
    EXPECT_EQ(wheels_.gate, wheel_state_t::GATE_LATCHED);
    EXPECT_FALSE(rig_->driven());
    say(stop_t::ACTION_RELEASE, false);
    pass(100 * kMs);
    EXPECT_EQ(wheels_.gate, wheel_state_t::GATE_LATCHED);
  }
  EXPECT_EQ(counters().at("release_not_a_person"), 1);
  say(stop_t::ACTION_RELEASE);
  pass(600 * kMs);
  EXPECT_TRUE(rig_->driven());
  EXPECT_FALSE(motor::LatchFile(config_.latch_file).load().latched);
  EXPECT_TRUE(was_logged("released by anna?[2J"));
}

TEST_F(MotorNodeTest, HazardM11_ADamagedLatchFileHoldsTheRobotAndIsNamed) {
  fs::create_directories(folder_.path() / "state");
  std::ofstream(config_.latch_file) << "cairn latch 1\nreleased by anna\nchecksum 0\n";
  start();
  planner_ = true;
  EXPECT_NE(why().find(config_.latch_file + ": is damaged"), std::string::npos) << status_.reason;
  EXPECT_FALSE(rig_->driven());
  EXPECT_EQ(wheels_.gate, wheel_state_t::GATE_LATCHED);
}

TEST_F(MotorNodeTest, AStopIsObeyedHoweverOldItSaysThatItIs) {
  start();
  planner_ = true;
  pass(500 * kMs);
  stop_t message{};
  message.header.sent_steady_us = std::numeric_limits<std::int64_t>::min();
  message.action = stop_t::ACTION_STOP;
  bus::Bus& stranger = hub_.make_endpoint();
  ASSERT_TRUE(stranger.publish(channels::Stop::name, bus::encode(message).value()));
  pass(20 * kMs);
  EXPECT_EQ(wheels_.gate, wheel_state_t::GATE_LATCHED);
}

TEST_F(MotorNodeTest, SaysInWordsWhyNothingMoves) {
  start();
  EXPECT_EQ(why(), "idle: nobody has told it to move");
  EXPECT_EQ(status_.health, process_status_t::HEALTH_OK);
  planner_ = true;
  EXPECT_EQ(why(), "");
  planner_ = false;
  EXPECT_EQ(why(), "idle: the driver is silent");
  planner_ = true;
  guard_ = false;
  EXPECT_EQ(why(), "no clearance: guard is silent");
  EXPECT_EQ(status_.health, process_status_t::HEALTH_WAITING);
  for (int i = 0; i < 100; ++i) {
    clear(0, "obstacle at 0.3" + std::to_string(i % 10) + " m");
    pass(50 * kMs);
  }
  clear(0, "obstacle at 0.31 m");
  EXPECT_EQ(status_.reason.substr(0, 28), "no clearance: obstacle at 0.");
  tick_ = false;
  EXPECT_EQ(why(), "no clock: CLOCK stands still");
  EXPECT_EQ(status_.health, process_status_t::HEALTH_WAITING);
  rig_->silent = true;
  EXPECT_EQ(why(), "no wheel controller: the line: the wheel controller has fallen silent");
  EXPECT_EQ(status_.health, process_status_t::HEALTH_ILL);
  EXPECT_EQ(wheels_.faults, 1);
  int about_obstacles = 0;
  for (const std::string& line : log_) {
    if (line.find("holds still: no clearance") != std::string::npos) ++about_obstacles;
  }
  EXPECT_LE(about_obstacles, 2) << "a reason with a number in it is said once";
  EXPECT_TRUE(was_logged("holds still: no clock"));
  EXPECT_TRUE(was_logged("holds still: no wheel controller"));
}

TEST_F(MotorNodeTest, AClearanceThatMakesNoSenseTakesAwayTheOneBefore) {
  start();
  planner_ = true;
  pass(1000 * kMs);
  ASSERT_TRUE(rig_->driven());
  guard_ = false;
  clear(std::nan(""), "free");
  pass(8 * kMs);
  EXPECT_FALSE(rig_->driven());
  EXPECT_EQ(counters().at("clearance_malformed"), 1);
}

TEST_F(MotorNodeTest, AClockThatMakesNoSenseIsRefused) {
  start();
  pass(500 * kMs);
  cairn::clock_t tick{};
  tick.rate = std::nan("");
  peer_.publish<channels::Clock>(tick, data_now());
  tick.rate = 1;
  peer_.publish<channels::Clock>(tick, std::numeric_limits<Utime>::max());
  pass(kMs);
  EXPECT_TRUE(was_logged("CLOCK: refused"));
  EXPECT_EQ(node_->data_time(), kData_us + 500 * kMs);
}

TEST_F(MotorNodeTest, AtItsEndTheWheelsGetZero) {
  start();
  planner_ = true;
  pass(1000 * kMs);
  ASSERT_TRUE(rig_->driven());
  ASSERT_TRUE(motor_->finish());
  rig_->run(clock_.now_us() + kMs);
  EXPECT_FALSE(rig_->driven());
}

TEST_F(MotorNodeTest, WithoutAPlaceForTheLatchFileItDoesNotStart) {
  const char* home = std::getenv("HOME");
  const std::string kept = home != nullptr ? home : "";
  ::unsetenv("HOME");
  ::unsetenv("XDG_STATE_HOME");
  bus::Node node("motor", hub_.make_endpoint(), clock_, {}, 9);
  const auto created = MotorNode::create(MotorConfig{}, node);
  if (home != nullptr) ::setenv("HOME", kept.c_str(), 1);
  ASSERT_FALSE(created);
  EXPECT_NE(created.error().message.find("latch_file"), std::string::npos);
}

/// What motor and its rig come to in lockstep, on so many threads.
struct Come {
  std::vector<std::uint8_t> wheel_states;
  std::int64_t count = 0;
  double way_m = 0;
};

Come in_lockstep(int threads) {
  Come come;
  bus::Lockstep lockstep(threads);
  bus::Node& host = lockstep.add("simulator", {});
  auto [controller_end, motor_end] = motor::make_memory_links([&host] { return host.host_time(); });
  testing::WheelRig rig(std::move(controller_end), 1, 0);
  host.every_host(10 * kMs, [&] { rig.run(host.host_time()); });
  host.every_host(50 * kMs, [&] {
    cairn::clock_t tick{};
    tick.rate = 1;
    host.publish<channels::Clock>(tick, kData_us + host.host_time());
  });
  bus::Node& motor_node = lockstep.add("motor", {});
  MotorConfig config;
  config.latch_file = "";
  auto motor =
      MotorNode::create(config, motor_node, motor::open_once(std::move(motor_end))).value();
  bus::Node& others = lockstep.add("others", {});
  others.every_host(50 * kMs, [&] {
    clearance_t clearance{};
    clearance.max_forward_mps = 0.4;
    clearance.disparity_utime = others.data_time();
    others.publish<channels::Clearance>(clearance, others.data_time());
    drive_command_t command{};
    command.source = drive_command_t::SOURCE_PLANNER;
    command.forward_mps = 0.35;
    command.turn_radps = 0.3;
    others.publish<channels::DriveCommand>(command, others.data_time());
  });
  others.on<channels::WheelState>([&](const wheel_state_t& heard) {
    const auto bytes = bus::encode(heard).value();
    come.wheel_states.insert(come.wheel_states.end(), bytes.begin(), bytes.end());
    ++come.count;
  });
  lockstep.run(host, [&] { return host.host_time() < 10 * kMicrosecondsPerSecond; });
  come.way_m = (rig.left.way_m + rig.right.way_m) / 2;
  return come;
}

TEST(MotorInLockstep, IsTheSameToTheByteOnAnyNumberOfThreads) {
  const Come once = in_lockstep(1);
  EXPECT_NEAR(static_cast<double>(once.count), 500, 5);
  EXPECT_GT(once.way_m, 0.3 * 9);
  for (const int threads : {1, 2, 4})
    EXPECT_EQ(in_lockstep(threads).wheel_states, once.wheel_states);
}

}  // namespace
}  // namespace cairn
