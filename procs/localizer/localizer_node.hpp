// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/geometry.hpp"
#include "messages/map_follower.hpp"

namespace cairn {

struct LocalizerConfig {
  void visit(ConfigVisitor&) {}
};

/// localizer: where the robot is in the map. POSE(k) = T_map_odom * ODOMETRY(k), sent as soon as
/// ODOMETRY(k) is there.
class LocalizerNode {
 public:
  using Config = LocalizerConfig;
  static constexpr const char* kName = "localizer";
  static constexpr const char* kAbout =
      "localizer: turns ODOMETRY, DISPARITY and the map into POSE";

  [[nodiscard]] static Result<std::unique_ptr<LocalizerNode>> create(const Config& config,
                                                                     bus::Node& node);

  explicit LocalizerNode(bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  void publish_pose(const odometry_t& odometry);

  bus::Node& node_;
  messages::MapFollower map_;
  Isometry T_map_odom_ = Isometry::Identity();
};

}  // namespace cairn
