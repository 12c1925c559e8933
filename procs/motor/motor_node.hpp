// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/clearance_t.hpp>
#include <cairn/clock_t.hpp>
#include <cairn/drive_command_t.hpp>
#include <cairn/stop_t.hpp>
#include <memory>
#include <optional>
#include <string>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/robot.hpp"
#include "motor/latch_file.hpp"
#include "motor/motor_control.hpp"

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

  /// On the serial line of the config, which it opens, and opens again whenever it is lost. An
  /// error: there is no place for the latch file.
  [[nodiscard]] static Result<std::unique_ptr<MotorNode>> create(const Config& config,
                                                                 bus::Node& node);

  /// On any line that `open` opens, as often as it is lost; `device` and `baud` do not matter. In
  /// lockstep: `motor::open_once` of one end of `motor::make_memory_links`.
  [[nodiscard]] static Result<std::unique_ptr<MotorNode>> create(const Config& config,
                                                                 bus::Node& node,
                                                                 motor::OpenLine open);

  MotorNode(const MotorNode&) = delete;
  MotorNode& operator=(const MotorNode&) = delete;

  /// Sends the wheels zero.
  [[nodiscard]] Result<void> finish();

 private:
  MotorNode(const Config& config, bus::Node& node, motor::WheelLine line, motor::LatchFile file);

  void take(const drive_command_t& message);
  void take(const clearance_t& message);
  void take(const cairn::clock_t& message);
  void take(const stop_t& message);
  void stop(const std::string& who);
  void release(const stop_t& message);
  void save_latch();
  void refuse(const char* channel, const char* prefix, const motor::Refusal& refusal);
  void tick();
  void publish(const motor::WheelReading& reading);
  void say_how_it_is();
  [[nodiscard]] std::string why_it_stands() const;
  void log_change(const std::string& why);
  void show_counts();

  Config config_;
  bus::Node& node_;
  motor::LatchFile latch_file_;
  motor::LatchFile::State latch_;
  bool latch_saved_ = true;
  std::string latch_error_;
  HostTime latch_tried_us_ = 0;
  motor::MotorControl control_;
  std::string guards_reason_;
  std::string seen_why_;  ///< why it stood still at the last look
  HostTime seen_since_us_ = 0;
  std::optional<std::string> logged_why_;
};

}  // namespace cairn
