// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/map_command_t.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "mapping/evidence.hpp"
#include "mapping/integrator.hpp"
#include "mapping/map_file.hpp"
#include "mapping/map_journal.hpp"
#include "mapping/voxel_map.hpp"
#include "procs/mapper/map_publisher.hpp"

namespace cairn {

struct MapperConfig {
  double resolution_m = 0.01;
  std::string pose = "POSE";
  double min_quality = 0.1;
  std::string integration = "projective";
  mapping::RayIntegratorConfig rays;
  mapping::EvidenceConfig evidence;
  std::string map;
  bool integrate = true;

  void visit(ConfigVisitor& v) {
    v.number("resolution_m", resolution_m, {0.001, 1}, "m", "side of a voxel");
    v.choice("pose", pose, {"POSE", "ODOMETRY"},
             "whose word is taken for where the robot is; ODOMETRY where no localizer runs");
    v.number("min_quality", min_quality, {0, 1}, "",
             "frames whose ODOMETRY is worse are not mapped (pose ODOMETRY)");
    v.choice(
        "integration", integration, {"projective", "exact"},
        "how voxels are freed: projective holds them against the depth image; exact walks every "
        "ray, some ten times slower, as the reference");
    v.group("rays", rays, "how a frame becomes evidence");
    v.group("evidence", evidence, "how evidence becomes occupied and free");
    v.text("map", map, "map file to go on with; empty: an empty map");
    v.flag("integrate", integrate, "false: the map stays as it is, whatever is seen");
  }
};

/// mapper: turns what was seen, from where the robot was, into the voxel map. Joins DISPARITY and
/// POSE (or ODOMETRY) by utime; maps where the robot is sure of its pose. Keeps its map in the
/// state folder: killed at any moment it goes on with all but the last second.
class MapperNode {
 public:
  using Config = MapperConfig;
  static constexpr const char* kName = "mapper";
  static constexpr const char* kAbout =
      "mapper: turns DISPARITY and POSE into the voxel map (MAP_DELTA, map.cairn)";

  /// An error names the map file that cannot be gone on with.
  [[nodiscard]] static Result<std::unique_ptr<MapperNode>> create(const Config& config,
                                                                  bus::Node& node);

  MapperNode(const Config& config, mapping::VoxelMap map, const mapping::MapInfo& info,
             bus::Node& node);

  /// Saves the map into the state folder, if there is one.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const mapping::VoxelMap& map() const { return map_; }
  [[nodiscard]] const mapping::MapInfo& info() const { return info_; }

 private:
  void take_posed(const disparity_t& seen, const pose_t& from);
  void take_odometric(const disparity_t& seen, const odometry_t& from);
  void integrate(const disparity_t& seen, const isometry_t& T_map_body);
  void obey(const map_command_t& command);
  void keep_journal();

  Config config_;
  bus::Node& node_;
  mapping::VoxelMap map_;
  mapping::MapInfo info_;
  std::unique_ptr<mapping::Integrator> integrator_;
  std::optional<mapping::MapJournal> journal_;
  std::vector<mapping::BrickIndex> changed_;  ///< by the frame in work
  MapPublisher publisher_;
};

}  // namespace cairn
