// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/disparity_t.hpp>
#include <cairn/localizer_command_t.hpp>
#include <cairn/odometry_t.hpp>
#include <memory>

#include "bus/join.hpp"
#include "bus/node.hpp"
#include "core/config.hpp"
#include "localization/localizer.hpp"
#include "messages/map_follower.hpp"

namespace cairn {

/// localizer: where the robot is in the map. POSE(k) = T_map_odom * ODOMETRY(k), sent as soon as
/// ODOMETRY(k) is there; what DISPARITY(k) shows of the map corrects T_map_odom from POSE(k+2) on.
/// Killed at any moment it goes on from its last pose.
class LocalizerNode {
 public:
  using Config = localization::LocalizerConfig;
  static constexpr const char* kName = "localizer";
  static constexpr const char* kAbout =
      "localizer: turns ODOMETRY, DISPARITY and the map into POSE";

  [[nodiscard]] static Result<std::unique_ptr<LocalizerNode>> create(const Config& config,
                                                                     bus::Node& node);

  LocalizerNode(const Config& config, bus::Node& node);

  [[nodiscard]] Result<void> finish() { return {}; }

 private:
  void pass_on(const odometry_t& odometry);
  void publish_pose(const odometry_t& odometry);
  void update();
  void update(const disparity_t& seen);
  void ask_for_map();
  void obey(const localizer_command_t& command);
  void show_particles();
  void resume();
  void remember();

  bus::Node& node_;
  bus::Join<disparity_t, odometry_t> frames_;
  messages::MapFollower map_;
  localization::Localizer localizer_;
  Isometry T_map_body_ = Isometry::Identity();  ///< as last published
};

}  // namespace cairn
