// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/robot.hpp"
#include "motor/byte_link.hpp"
#include "motor/track_pid.hpp"

namespace cairn {

struct MotorConfig {
  RobotConfig robot;
  std::string device;
  int baud = 115'200;
  motor::TrackPidConfig pid;
  std::string latch_file = "$XDG_STATE_HOME/cairn/latch";

  void visit(ConfigVisitor& v) {
    v.group("robot", robot, "the robot's size and limits");
    v.text("device", device,
           "serial line of the wheel controller, for example a link in /dev/serial/by-id");
    v.integer("baud", baud, 1200, 4'000'000, "1/s", "speed of the serial line");
    v.group("pid", pid, "how a track is held at its speed");
    v.text("latch_file", latch_file,
           "where STOP is kept over every restart, outside the run; $XDG_STATE_HOME is "
           "~/.local/state where it is not set; empty: STOP ends with the process");
  }
};

/// motor: the only one that speaks to the wheels. Holds still unless told, freshly and with a clear
/// view, to move (DESIGN rule 7).
class MotorNode {
 public:
  using Config = MotorConfig;
  static constexpr const char* kName = "motor";
  static constexpr const char* kAbout =
      "motor: carries out DRIVE_COMMAND within CLEARANCE and STOP, publishes WHEEL_STATE";

  /// On the serial line of the config, which it opens, and opens again whenever it is lost.
  [[nodiscard]] static Result<std::unique_ptr<MotorNode>> create(const Config& config,
                                                                 bus::Node& node);

  /// On any line that `open` opens, as often as it is lost; `device` and `baud` do not matter. In
  /// lockstep: `motor::open_once` of one end of `motor::make_memory_links`.
  [[nodiscard]] static Result<std::unique_ptr<MotorNode>> create(const Config& config,
                                                                 bus::Node& node,
                                                                 motor::OpenLine open);

  virtual ~MotorNode() = default;

  /// Sends the wheels zero.
  [[nodiscard]] virtual Result<void> finish() = 0;
};

}  // namespace cairn
