// SPDX-License-Identifier: Apache-2.0
// What one frame of the simulated robot costs each process that looks at it: 640x480, its lenses,
// its config, on the way round a room.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "bus/in_process_bus.hpp"
#include "bus/process.hpp"
#include "messages/calibration_messages.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/image_messages.hpp"
#include "procs/mapper/mapper_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/stereo/stereo_node.hpp"
#include "simulation/drive_path.hpp"
#include "simulation/renderer.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;
namespace fs = std::filesystem;

constexpr std::size_t kFrames = 90;
constexpr std::size_t kWarmUp = 5;
constexpr Utime kFrame_us = 66'667;

/// Processor time of this thread [ms]: what other programs do meanwhile is left out.
double thread_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

template <class Config>
Config robot_config(const char* process) {
  return load_config<Config>({fs::path(CAIRN_SOURCE_DIR) / "config/robots/simulated.yaml", {}},
                             process, bus::kConfigSections)
      .value();
}

/// A process on the in-process bus, and how long it worked on each frame.
template <class ProcessNode>
class Measured {
 public:
  Measured(bus::InProcessHub& hub, const bus::HostClock& clock)
      : node_{ProcessNode::kName, hub.make_endpoint(), clock, StateFolder{}, ++sessions_},
        process_{ProcessNode::create(robot_config<typename ProcessNode::Config>(ProcessNode::kName),
                                     node_)
                     .value()} {}

  void work() {
    const double before_ms = thread_ms();
    do {
      node_.spin_once(0);
    } while (node_.has_work());
    ms_.push_back(thread_ms() - before_ms);
  }

  void report() {
    std::vector<double> ms(ms_.begin() + kWarmUp, ms_.end());
    std::sort(ms.begin(), ms.end());
    std::cout << ProcessNode::kName << ": mean "
              << std::accumulate(ms.begin(), ms.end(), 0.0) / static_cast<double>(ms.size())
              << " ms, median " << ms[ms.size() / 2] << ", least " << ms.front() << ", most "
              << ms.back() << "\n";
  }

  bus::Node& node() { return node_; }

 private:
  static inline std::int64_t sessions_ = 1;
  bus::Node node_;
  std::unique_ptr<ProcessNode> process_;
  std::vector<double> ms_;
};

TEST(FrameCost, PrintsWhatAFrameCostsEachProcess) {
  cv::setNumThreads(1);
  const auto world =
      simulation::load_world(fs::path(CAIRN_SOURCE_DIR) / "config/worlds/room.yaml").value();
  const auto rig = messages::as_sent(
      camera::load_rig(std::string(CAIRN_SOURCE_DIR) + "/config/calibration/simulated-25cm.yaml")
          .value());
  const auto eyes = simulation::Renderer::create(world, rig, {}, 1).value();
  simulation::DriveConfig drive;
  drive.speed_mps = 0.3;
  const auto path = simulation::drive_round(simulation::room_tour_m(), drive);

  bus::ManualClock clock;
  bus::InProcessHub hub;
  bus::Bus& robot_bus = hub.make_endpoint();
  bus::Node robot{"robot", robot_bus, clock, StateFolder{}, 1};
  Measured<StereoNode> stereo{hub, clock};
  Measured<OdometryNode> odometry{hub, clock};
  Measured<MapperNode> mapper{hub, clock};
  messages::FrameEncoder encoder;
  robot.publish<channels::Calibration>(messages::to_message(rig, 0), 0);
  ASSERT_GE(path.size(), kFrames);
  for (std::size_t i = 0; i < kFrames; ++i) {
    const Utime utime = 1'000'000 + static_cast<Utime>(i) * kFrame_us;
    const auto pair = eyes.render(path[i].T, static_cast<std::int64_t>(i));
    auto frame =
        encoder.encode({static_cast<std::int64_t>(i), utime, pair.left, pair.right, {}, 0}, rig.id);
    ASSERT_TRUE(frame) << frame.error().message;
    robot.publish<channels::StereoFrame>(std::move(*frame), utime);
    pose_t pose{};
    pose.T_map_body = messages::to_message(path[i].T);
    pose.T_map_odom = messages::to_message(Isometry::Identity());
    pose.state = pose_t::STATE_TRACKING;
    robot.publish<channels::Pose>(pose, utime);
    hub.deliver();
    stereo.work();
    odometry.work();
    hub.deliver();
    mapper.work();
  }
  stereo.report();
  odometry.report();
  mapper.report();
  EXPECT_EQ(mapper.node().counter("frames_mapped"), static_cast<std::int64_t>(kFrames));
}

}  // namespace
}  // namespace cairn
