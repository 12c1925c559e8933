// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/config.hpp"

namespace cairn::camera {

/// Two webcams, and how they are to capture. Name devices by /dev/v4l/by-path/...: those names
/// outlive a cable that is pulled and put back, and do not swap at boot.
struct V4l2Config {
  std::string left_device = "/dev/video0";
  std::string right_device = "/dev/video2";
  int width_px = 640;
  int height_px = 480;
  double rate_hz = 30;
  std::string format = "any";
  int exposure_us = 10000;
  int white_balance_k = 4600;
  int gain = -1;
  double max_skew_ms = 5;
  int timeout_ms = 300;
  int start_timeout_ms = 2500;

  void visit(ConfigVisitor& v) {
    v.text("left_device", left_device, "video device of the left camera");
    v.text("right_device", right_device, "video device of the right camera");
    v.integer("width_px", width_px, 16, 8192, "px", "image width, that of the rig");
    v.integer("height_px", height_px, 16, 8192, "px", "image height, that of the rig");
    v.number("rate_hz", rate_hz, {1, 240}, "Hz",
             "frames per second; the driver may choose the nearest");
    v.choice("format", format, {"any", "grey", "yuyv", "mjpg"},
             "any: the first of grey, yuyv, mjpg; mjpg if two cameras share one USB controller");
    v.integer("exposure_us", exposure_us, 0, 1'000'000, "us", "locked exposure time; 0: automatic");
    v.integer("white_balance_k", white_balance_k, 0, 20'000, "K", "locked; 0: automatic");
    v.integer("gain", gain, -1, 65'535, "", "locked, in the driver's units; -1: leave it");
    v.number("max_skew_ms", max_skew_ms, {0.1, 1000}, "ms",
             "left and right further apart are no pair");
    v.integer("timeout_ms", timeout_ms, 10, 60'000, "ms",
              "no frame for this long: the camera is out");
    v.integer("start_timeout_ms", start_timeout_ms, 10, 60'000, "ms",
              "time for the first frame after a device is opened");
  }
};

}  // namespace cairn::camera
