// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "bus/node.hpp"
#include "motor/byte_link.hpp"
#include "procs/simulator/simulator_config.hpp"

namespace cairn {

/// simulator: stands in for the camera process and the wheel hardware, so that all other processes
/// are the ones that go on a robot. Publishes STEREO_FRAME (`fast`: DISPARITY and ODOMETRY),
/// CALIBRATION, CLOCK, TRUTH and SIM_STATE; a wheel controller answers on its line.
///
/// Live: `create` makes the pseudo-terminal that `wheel_device` names and paints pictures on a
/// thread of its own. Data time begins at kStart_us and goes on with host time, `speed` times as
/// fast; above 1 it is a ceiling: frame k + 2 waits for POSE and DISPARITY of frame k, and frame
/// k + 8 for the MAP_DELTA that is complete through k.
///
/// In lockstep: `create_for_lockstep`, on one end of a line in memory whose other end goes to
/// MotorNode. It paints within the step, waits for nothing, and gives the same bytes:
///
///     bus::Node& host = lockstep.add("simulator", {});
///     auto [controller_end, motor_end] =
///         motor::make_memory_links([&host] { return host.host_time(); });
///     auto simulator = SimulatorNode::create_for_lockstep(config, host,
///     std::move(controller_end));
///     ... MotorNode and the others ...
///     lockstep.run(host, [&] { return !done; });
///
/// It never ends by itself: live it runs until SIGTERM or SIGINT, in lockstep until `go_on` says
/// no. Started anew it begins anew, at kStart_us, with the robot at the world's start.
class SimulatorNode {
 public:
  using Config = SimulatorConfig;
  static constexpr const char* kName = "simulator";
  static constexpr const char* kAbout =
      "simulator: plays a place, a robot in it, its cameras and its wheel controller";
  static constexpr Utime kStart_us = kMicrosecondsPerSecond;  ///< utime of frame 0

  [[nodiscard]] static Result<void> check(const Config& config);

  /// An error names the key, or the file and line, that does not serve.
  [[nodiscard]] static Result<std::unique_ptr<SimulatorNode>> create(const Config& config,
                                                                     bus::Node& node);
  /// `wheel_device` and `speed` count for nothing here.
  [[nodiscard]] static Result<std::unique_ptr<SimulatorNode>> create_for_lockstep(
      const Config& config, bus::Node& node, std::unique_ptr<motor::ByteLink> wheel_line);

  ~SimulatorNode();
  SimulatorNode(const SimulatorNode&) = delete;
  SimulatorNode& operator=(const SimulatorNode&) = delete;

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  struct State;
  explicit SimulatorNode(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
