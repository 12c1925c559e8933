// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/simulator_node.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bus/in_process_bus.hpp"
#include "bus/lockstep.hpp"
#include "messages/calibration_messages.hpp"
#include "messages/check.hpp"
#include "messages/disparity_messages.hpp"
#include "messages/geometry_messages.hpp"
#include "motor/memory_link.hpp"
#include "motor/wheel_protocol.hpp"
#include "scenes.hpp"
#include "simulation/renderer.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;

SimulatorConfig room() {
  SimulatorConfig config;
  config.world = simulation::room_file().string();
  config.rig = std::string(CAIRN_SOURCE_DIR) + "/config/calibration/simulated-25cm.yaml";
  config.people = 1;
  return config;
}

/// Hears everything that a simulator says.
struct Listener {
  std::vector<stereo_frame_t> frames;
  std::vector<disparity_t> disparities;
  std::vector<odometry_t> odometry;
  std::vector<pose_t> truth;
  std::vector<sim_state_t> states;
  std::vector<Utime> ticks;
  std::vector<HostTime> ticks_sent_us;
  std::vector<rig_calibration_t> calibrations;

  explicit Listener(bus::Node& node) {
    node.on<channels::StereoFrame>([this](const stereo_frame_t& m) { frames.push_back(m); });
    node.on<channels::Disparity>([this](const disparity_t& m) { disparities.push_back(m); });
    node.on<channels::Odometry>([this](const odometry_t& m) { odometry.push_back(m); });
    node.on<channels::Truth>([this](const pose_t& m) { truth.push_back(m); });
    node.on<channels::SimState>([this](const sim_state_t& m) { states.push_back(m); });
    node.on<channels::Calibration>(
        [this](const rig_calibration_t& m) { calibrations.push_back(m); });
    node.on<channels::Clock>([this](const cairn::clock_t& m) {
      ticks.push_back(m.header.utime);
      ticks_sent_us.push_back(m.header.sent_steady_us);
    });
  }
};

bool same_pose(const pose_t& a, const pose_t& b) {
  return messages::to_isometry(a.T_map_body, "T").value().matrix() ==
         messages::to_isometry(b.T_map_body, "T").value().matrix();
}

/// Somebody at the other end of the wheel line who gives the same duties 50 times a second of data
/// time, for as long as he is told, and keeps the newest report.
class Driver {
 public:
  Driver(bus::Node& node, std::unique_ptr<motor::ByteLink> line)
      : node_{node}, line_{std::move(line)} {
    node.every_host(20'000, [this] { turn(); });
  }

  void drive(double left, double right, HostTime until_us) {
    left_ = left;
    right_ = right;
    until_us_ = until_us;
  }

  struct Report {
    motor::ReportFrame frame;
    HostTime read_us;
  };
  std::vector<Report> reports;

 private:
  void turn() {
    const auto bytes = line_->read();
    for (const std::uint8_t byte : bytes.value()) {
      if (parser_.take(byte) == motor::FrameParser::Kind::kReport)
        reports.push_back({parser_.report(), node_.host_time()});
    }
    if (node_.host_time() > until_us_) return;
    const auto wire = motor::to_wire(motor::DriveFrame{++number_, left_, right_});
    ASSERT_TRUE(line_->write(wire.bytes()));
  }

  bus::Node& node_;
  std::unique_ptr<motor::ByteLink> line_;
  motor::FrameParser parser_;
  std::uint32_t number_ = 0;
  double left_ = 0;
  double right_ = 0;
  HostTime until_us_ = -1;
};

/// A simulator in lockstep with a driver and a listener.
class LockstepRun {
 public:
  explicit LockstepRun(const SimulatorConfig& config)
      : host_{lockstep_.add("simulator", {})},
        driver_node_{lockstep_.add("driver", {})},
        listener_node_{lockstep_.add("listener", {})},
        listener{listener_node_} {
    auto [controller_end, driver_end] =
        motor::make_memory_links([this] { return host_.host_time(); });
    driver.emplace(driver_node_, std::move(driver_end));
    auto created = SimulatorNode::create_for_lockstep(config, host_, std::move(controller_end));
    EXPECT_TRUE(created) << created.error().message;
    simulator_ = std::move(*created);
  }

  void run_until(double seconds) {
    const auto end_us = static_cast<HostTime>(1e6 * seconds);
    lockstep_.run(host_, [&] { return host_.host_time() < end_us; });
  }

 private:
  bus::Lockstep lockstep_{1};
  bus::Node& host_;
  bus::Node& driver_node_;
  bus::Node& listener_node_;
  std::unique_ptr<SimulatorNode> simulator_;

 public:
  Listener listener;
  std::optional<Driver> driver;
};

TEST(SimulatorNode, SaysWhatACameraSaysAndWhatIsTrue) {
  LockstepRun run(room());
  run.run_until(1.97);
  const Listener& heard = run.listener;
  ASSERT_EQ(heard.frames.size(), 30U);
  ASSERT_EQ(heard.truth.size(), 30U);
  ASSERT_EQ(heard.states.size(), 30U);
  EXPECT_EQ(heard.calibrations.size(), 2U);
  EXPECT_TRUE(heard.disparities.empty());
  const auto rig = messages::to_rig(heard.calibrations.front());
  ASSERT_TRUE(rig) << rig.error().message;
  for (std::size_t k = 0; k < 30; ++k) {
    const auto due =
        SimulatorNode::kStart_us + static_cast<Utime>(1e6 / 15 * static_cast<double>(k));
    EXPECT_GE(heard.frames[k].header.utime, due);
    EXPECT_LT(heard.frames[k].header.utime, due + 5'000);
    EXPECT_EQ(heard.frames[k].frame_index, static_cast<std::int64_t>(k));
    EXPECT_EQ(heard.frames[k].calibration_id, heard.calibrations.front().calibration_id);
    EXPECT_TRUE(messages::check(heard.frames[k]));
    EXPECT_TRUE(messages::check(heard.truth[k]));
    EXPECT_EQ(heard.truth[k].header.utime, heard.frames[k].header.utime);
    EXPECT_EQ(heard.states[k].header.utime, heard.frames[k].header.utime);
    EXPECT_LE(heard.frames[k].getEncodedSize(), messages::FrameEncoder::kDefaultBudget_bytes);
  }
  for (std::size_t i = 1; i < heard.ticks.size(); ++i) {
    EXPECT_GT(heard.ticks[i], heard.ticks[i - 1]);
    EXPECT_LE(heard.ticks[i] - heard.ticks[i - 1], 50'000);
  }
}

TEST(SimulatorNode, KeepsTheTruthToItselfWhenTold) {
  SimulatorConfig config = room();
  config.publish_truth = false;
  LockstepRun run(config);
  run.run_until(0.5);
  EXPECT_FALSE(run.listener.frames.empty());
  EXPECT_TRUE(run.listener.truth.empty());
  EXPECT_TRUE(run.listener.states.empty());
}

TEST(SimulatorNode, PicturesAreThoseOfTheTruePose) {
  SimulatorConfig config = room();
  config.people = 0;
  LockstepRun run(config);
  run.driver->drive(-0.3, 0.3, 2'000'000);
  run.run_until(1.5);
  const auto& heard = run.listener;
  ASSERT_GE(heard.frames.size(), 20U);
  const auto rig = messages::to_rig(heard.calibrations.front()).value();
  const auto world = simulation::load_world(config.world).value();
  simulation::SensorConfig without_noise = config.sensor;
  without_noise.read_noise_grey = 0;
  without_noise.shot_noise_grey = 0;
  const auto eyes = simulation::Renderer::create(world, rig, without_noise, 1).value();
  const auto difference = [&](const cv::Mat& image, const Isometry& T) {
    return cv::norm(image, eyes.render(T, 0).left, cv::NORM_L1) /
           static_cast<double>(image.total());
  };
  for (const std::size_t k : {0U, 8U, 19U}) {
    const auto images = messages::to_images(heard.frames[k]).value();
    const auto T = messages::to_isometry(heard.truth[k].T_map_body, "T").value();
    EXPECT_LT(difference(images.left, T), 7) << k;
    const Isometry beside = T * simulation::pose_2d(0, 0, 0.02);
    EXPECT_GT(difference(images.left, beside), difference(images.left, T) + 1) << k;
  }
}

TEST(SimulatorNode, DrivesByItsWheelLine) {
  SimulatorConfig config = room();
  config.people = 0;
  LockstepRun run(config);
  run.driver->drive(0.25, 0.25, 1'000'000);
  run.run_until(1);
  const auto& reports = run.driver->reports;
  ASSERT_GE(reports.size(), 45U);
  for (std::size_t i = 1; i < reports.size(); ++i)
    EXPECT_EQ(reports[i].frame.device_us - reports[i - 1].frame.device_us, 20'000);
  // 0.2 m/s for a second, less what the motor's delay and the line's take.
  EXPECT_NEAR(static_cast<double>(reports.back().frame.left_ticks), 0.2 * 0.87 * 5000, 40);
  const auto first = messages::to_isometry(run.listener.truth.front().T_map_body, "T").value();
  const auto last = messages::to_isometry(run.listener.truth.back().T_map_body, "T").value();
  EXPECT_NEAR((first.inverse() * last).translation().x(), 0.2 * 0.8 * 0.97, 0.02);
  EXPECT_NEAR(run.listener.states.back().left_track_mps, 0.2 * 0.97, 0.02);
}

TEST(SimulatorNode, SilenceStopsTheTracksWithinTwoHundredMilliseconds) {
  LockstepRun run(room());
  constexpr HostTime kLast_us = 1'000'000;
  run.driver->drive(0.25, 0.25, kLast_us);
  run.run_until(2);
  const auto& reports = run.driver->reports;
  bool drove = false;
  for (const auto& report : reports) {
    drove = drove || report.frame.left_duty > 0.2;
    // The report was written by the wave before, at most 20 ms ago.
    if (report.read_us > kLast_us + 200'000 + 25'000) {
      EXPECT_EQ(report.frame.left_duty, 0) << report.read_us;
      EXPECT_EQ(report.frame.right_duty, 0) << report.read_us;
    }
  }
  EXPECT_TRUE(drove);
  EXPECT_EQ(reports.back().frame.faults & motor::kControllerStarved, motor::kControllerStarved);
  EXPECT_NEAR(run.listener.states.back().left_track_mps, 0, 1e-3);
}

TEST(SimulatorNode, TwoRunsAreTheSameByteForByte) {
  const auto bytes_of = [](const SimulatorConfig& config) {
    LockstepRun run(config);
    run.driver->drive(0.3, 0.4, 2'000'000);
    run.run_until(1.2);
    std::vector<std::uint8_t> all;
    const auto add = [&](const auto& messages) {
      for (const auto& message : messages) {
        const auto bytes = bus::encode(message).value();
        all.insert(all.end(), bytes.begin(), bytes.end());
      }
    };
    add(run.listener.frames);
    add(run.listener.truth);
    add(run.listener.states);
    add(run.listener.disparities);
    add(run.listener.odometry);
    return all;
  };
  for (const bool fast : {false, true}) {
    SimulatorConfig config = room();
    config.fast = fast;
    const auto once = bytes_of(config);
    EXPECT_EQ(once, bytes_of(config));
    config.seed = 2;
    EXPECT_NE(once, bytes_of(config));
  }
}

TEST(SimulatorNode, FastItSaysWhatStereoAndOdometryWouldSay) {
  SimulatorConfig config = room();
  config.fast = true;
  LockstepRun run(config);
  run.driver->drive(0.2, 0.3, 3'000'000);
  run.run_until(2.97);
  const Listener& heard = run.listener;
  EXPECT_TRUE(heard.frames.empty());
  ASSERT_EQ(heard.disparities.size(), 45U);
  ASSERT_EQ(heard.odometry.size(), 45U);
  const auto first = messages::to_isometry(heard.truth.front().T_map_body, "T").value();
  for (std::size_t k = 0; k < 45; ++k) {
    EXPECT_EQ(heard.disparities[k].header.utime, heard.truth[k].header.utime);
    EXPECT_EQ(heard.odometry[k].header.utime, heard.truth[k].header.utime);
    EXPECT_TRUE(messages::check(heard.odometry[k]));
    const auto disparity = messages::to_disparity(heard.disparities[k]);
    ASSERT_TRUE(disparity) << disparity.error().message;
    EXPECT_EQ(disparity->cols(), 160);
    const auto T_odom = messages::to_isometry(heard.odometry[k].T_odom_body, "T").value();
    const auto T_true = messages::to_isometry(heard.truth[k].T_map_body, "T").value();
    EXPECT_LT(((first.inverse() * T_true).inverse() * T_odom).translation().norm(), 0.02);
  }
}

TEST(SimulatorNode, BeginsAnewWhenItIsStartedAnew) {
  SimulatorConfig config = room();
  config.people = 0;
  LockstepRun driven(config);
  driven.driver->drive(0.3, 0.3, 1'000'000);
  driven.run_until(1);
  LockstepRun anew(config);
  anew.run_until(0.3);
  EXPECT_EQ(anew.listener.frames.front().header.utime, SimulatorNode::kStart_us);
  EXPECT_TRUE(same_pose(anew.listener.truth.front(), driven.listener.truth.front()));
}

/// A live simulator on a bus of its own with the machine's clock or one that is set.
class LiveRun {
 public:
  LiveRun(SimulatorConfig config, const bus::HostClock& clock)
      : host_{"simulator", hub_.make_endpoint(), clock, StateFolder{}, 1},
        peer{"peer", hub_.make_endpoint(), clock, StateFolder{}, 2},
        listener{peer} {
    config.wheel_device = (folder_.path() / "wheels").string();
    auto created = SimulatorNode::create(config, host_);
    EXPECT_TRUE(created) << created.error().message;
    simulator_ = std::move(*created);
  }

  void spin() {
    host_.spin_once(0);
    hub_.deliver();
    do {
      peer.spin_once(0);
    } while (peer.has_work());
    hub_.deliver();
  }

  [[nodiscard]] std::int64_t count(const std::string& name) { return host_.counter(name); }

 private:
  testing::TemporaryFolder folder_;
  bus::InProcessHub hub_;
  bus::Node host_;
  std::unique_ptr<SimulatorNode> simulator_;

 public:
  bus::Node peer;
  Listener listener;
};

constexpr auto kSafety = std::chrono::seconds(120);

TEST(SimulatorNode, LiveItPaintsTheSamePicturesAsInLockstep) {
  SimulatorConfig config = room();
  config.speed = 0.1;  // so that a busy machine paints them all
  const bus::SteadyClock clock;
  LiveRun live(config, clock);
  constexpr std::size_t kFrames = 5;
  const auto end = std::chrono::steady_clock::now() + kSafety;
  while (live.listener.frames.size() < kFrames && std::chrono::steady_clock::now() < end)
    live.spin();
  ASSERT_GE(live.listener.frames.size(), kFrames);
  ASSERT_EQ(live.count("frames_not_painted"), 0);
  LockstepRun lockstep(config);
  lockstep.run_until(1);
  for (std::size_t k = 0; k < kFrames; ++k) {
    const auto& there = live.listener.frames[k];
    const auto& here = lockstep.listener.frames[k];
    EXPECT_EQ(there.header.utime, here.header.utime) << k;
    EXPECT_EQ(there.left, here.left) << k;
    EXPECT_EQ(there.right, here.right) << k;
    EXPECT_TRUE(same_pose(live.listener.truth[k], lockstep.listener.truth[k])) << k;
  }
}

TEST(SimulatorNode, FasterThanLifeItWaitsForTheRobot) {
  SimulatorConfig config = room();
  config.speed = 10;
  config.fast = true;
  bus::ManualClock clock;
  clock.set(1'000'000);
  LiveRun live(config, clock);
  // The robot is slow: it answers one frame in a tenth of a second, which is a second of data time.
  std::size_t answered = 0;
  for (int i = 1; i <= 3'000; ++i) {
    clock.set(clock.now_us() + 1'000);
    live.spin();
    const auto& seen = live.listener.disparities;
    ASSERT_LE(seen.size(), answered + 2);
    if (i % 100 != 0) continue;
    ASSERT_EQ(seen.size(), answered + 2) << "it waits for no reason";
    const Utime utime = seen[answered++].header.utime;
    live.peer.publish<channels::Pose>(pose_t{}, utime);
    map_delta_t map{};
    map.complete_through_utime = utime;
    live.peer.publish<channels::MapDelta>(map, utime);
  }
  EXPECT_EQ(answered, 30U);
}

TEST(SimulatorNode, WhileTimeStandsStillClockGoesOnSayingSo) {
  SimulatorConfig config = room();
  config.speed = 10;
  config.fast = true;
  bus::ManualClock clock;
  clock.set(1'000'000);
  LiveRun live(config, clock);
  for (int i = 0; i < 1'500; ++i) {
    clock.set(clock.now_us() + 1'000);
    live.spin();
  }
  const auto& ticks = live.listener.ticks;
  const auto& sent_us = live.listener.ticks_sent_us;
  EXPECT_EQ(live.listener.truth.size(), 2U);
  for (std::size_t i = 1; i < ticks.size(); ++i) EXPECT_LE(sent_us[i] - sent_us[i - 1], 50'000);
  EXPECT_EQ(ticks.back(), ticks[ticks.size() - 10]);
}

TEST(SimulatorNode, WithoutARobotItGoesOnAfterAWhile) {
  SimulatorConfig config = room();
  config.speed = 10;
  config.fast = true;
  bus::ManualClock clock;
  clock.set(1'000'000);
  LiveRun live(config, clock);
  for (int i = 0; i < 8'000; ++i) {
    clock.set(clock.now_us() + 1'000);
    live.spin();
  }
  EXPECT_GT(live.listener.truth.size(), 100U);
}

TEST(SimulatorNode, SaysWhatDoesNotServe) {
  testing::TemporaryFolder folder;
  const bus::SteadyClock clock;
  bus::InProcessHub hub;
  bus::Node node("simulator", hub.make_endpoint(), clock, StateFolder{}, 1);
  const auto error_of = [&](const SimulatorConfig& config) {
    const auto created = SimulatorNode::create(config, node);
    EXPECT_FALSE(created);
    return created ? std::string() : created.error().message;
  };
  const auto contains = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  SimulatorConfig good = room();
  good.wheel_device = (folder.path() / "wheels").string();

  SimulatorConfig config = good;
  config.world = "";
  contains(error_of(config), "simulator.world");
  config.world = "no/such/world.yaml";
  contains(error_of(config), "no/such/world.yaml");
  const auto broken = folder.path() / "broken.yaml";
  std::ofstream(broken)
      << "materials:\n  - {name: stone}\nboxes:\n  - {centre_m: [0, 0], size_m: [1, 1, 1]}\n";
  config.world = broken.string();
  contains(error_of(config), broken.string() + ":4");
  std::ofstream(broken) << "boxes: [unclosed\n";
  contains(error_of(config), broken.string() + ":");

  config = good;
  config.people = 90;
  contains(error_of(config), config.world + ": people");
  config = good;
  config.rig = "no/such/rig.yaml";
  contains(error_of(config), "no/such/rig.yaml");
  config = good;
  config.wheel_device = "";
  contains(error_of(config), "simulator.wheel_device");
  config.wheel_device = broken.string();
  contains(error_of(config), broken.string());
}

}  // namespace
}  // namespace cairn
