// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/config.hpp"

namespace cairn::odometry {

struct StereoOdometryConfig {
  int points = 250;
  int min_point_distance_px = 10;
  double max_disparity_px = 192;
  int min_inliers = 12;
  double keyframe_share = 0.6;
  double keyframe_flow_share = 0.1;
  double max_speed_mps = 30;
  double max_turn_radps = 6;
  double coast_s = 0.5;
  double coast_accel_mps2 = 1.0;
  double coast_turn_accel_radps2 = 3.0;
  int seed = 1;

  void visit(ConfigVisitor& v) {
    v.integer("points", points, 30, 2000, "", "how many points to follow");
    v.integer("min_point_distance_px", min_point_distance_px, 3, 100, "px",
              "how far apart the points lie at least");
    v.number("max_disparity_px", max_disparity_px, {16, 1024}, "px",
             "largest disparity searched for a new point");
    v.integer("min_inliers", min_inliers, 6, 200, "", "fewer agreeing points give no pose");
    v.number("keyframe_share", keyframe_share, {0.1, 0.95}, "",
             "a new keyframe when less than this share of the keyframe's points agree");
    v.number("keyframe_flow_share", keyframe_flow_share, {0.005, 0.5}, "",
             "a new keyframe when the points have moved by this share of the image's width");
    v.number("max_speed_mps", max_speed_mps, {0.1, 100}, "m/s", "a faster pose is not believed");
    v.number("max_turn_radps", max_turn_radps, {0.1, 50}, "rad/s", "a faster turn is not believed");
    v.number("coast_s", coast_s, {0, 10}, "s",
             "without points: time for which the last velocity is kept; then it is zero");
    v.number("coast_accel_mps2", coast_accel_mps2, {0, 50}, "m/s^2",
             "without points: acceleration to reckon with (one sigma)");
    v.number("coast_turn_accel_radps2", coast_turn_accel_radps2, {0, 100}, "rad/s^2",
             "without points: angular acceleration to reckon with (one sigma)");
    v.integer("seed", seed, 0, 1 << 30, "", "of the random triples that wrong points are found by");
  }
};

}  // namespace cairn::odometry
