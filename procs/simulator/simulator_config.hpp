// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/config.hpp"
#include "core/robot.hpp"
#include "messages/image_messages.hpp"
#include "simulation/sensor.hpp"
#include "simulation/track_drive.hpp"

namespace cairn {

struct SimulatorConfig {
  RobotConfig robot;
  std::string world;
  std::string rig = "config/calibration/simulated-25cm.yaml";
  int seed = 1;
  int people = 0;
  std::string wheel_device;
  double rate_hz = 15;
  double speed = 1;
  bool fast = false;
  int frame_budget_bytes = messages::FrameEncoder::kDefaultBudget_bytes;
  bool publish_truth = true;
  simulation::TracksConfig tracks;
  simulation::SensorConfig sensor;

  void visit(ConfigVisitor& v) {
    v.group("robot", robot, "the robot's size and limits");
    v.text("world", world, "world file: the place, and where the robot starts");
    v.text("rig", rig, "calibration file of the two cameras");
    v.integer("seed", seed, 0, 1'000'000'000, "",
              "of all that is random: image noise, slip, what people decide");
    v.integer("people", people, 0, 100, "", "how many of the world's people walk about");
    v.text("wheel_device", wheel_device,
           "symbolic link that is made to the wheel controller's line; motor opens it as a serial "
           "port");
    v.number("rate_hz", rate_hz, {1, 60}, "Hz", "frames a second");
    v.number("speed", speed, {0.1, 50}, "",
             "how many times faster than life; above 1 it is a ceiling: frames wait for what the "
             "robot makes of them");
    v.flag("fast", fast,
           "publish DISPARITY and ODOMETRY of a measured noise model instead of STEREO_FRAME: for "
           "statistics only");
    v.integer("frame_budget_bytes", frame_budget_bytes, 10'000, 50'000'000, "bytes",
              "the JPEG quality of each frame is chosen to fit this; over 115000 a stock kernel "
              "loses frames");
    v.flag("publish_truth", publish_truth,
           "publish TRUTH and SIM_STATE, which nobody on the robot reads");
    v.group("tracks", tracks, "what becomes of a motor's duty on the way to the ground");
    v.group("sensor", sensor, "how the two cameras differ from perfect ones and from each other");
  }
};

}  // namespace cairn
