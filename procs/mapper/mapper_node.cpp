// SPDX-License-Identifier: Apache-2.0
#include "procs/mapper/mapper_node.hpp"

#include <filesystem>
#include <utility>

#include "core/checksum.hpp"
#include "mapping/projective_integrator.hpp"
#include "mapping/ray_integrator.hpp"
#include "messages/check.hpp"
#include "messages/disparity_messages.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr const char* kMapFile = "map.cairn";
constexpr std::int64_t kJournalPeriod_us = kMicrosecondsPerSecond;
/// A journal larger than this is folded into the map file.
constexpr std::size_t kLargestJournal_bytes = std::size_t{64} << 20;

struct Start {
  mapping::VoxelMap map;
  mapping::MapInfo info;
};

Result<void> same_resolution(const Start& start, const MapperConfig& config,
                             const std::string& file) {
  if (start.map.resolution_m() == config.resolution_m) return {};
  return fail(file + ": has voxels of " + std::to_string(start.map.resolution_m()) +
              " m, mapper.resolution_m is " + std::to_string(config.resolution_m));
}

// What a killed mapper had, else the map file that the config names, else nothing.
Result<Start> starting_map(const MapperConfig& config, bus::Node& node) {
  if (node.state().enabled()) {
    auto recovered = mapping::recover_map(node.state().path(kMapFile), config.evidence);
    if (!recovered) return tl::make_unexpected(recovered.error());
    if (*recovered) {
      if (!(*recovered)->note.empty()) node.log(bus::Level::kWarning, (*recovered)->note);
      node.log(bus::Level::kInfo,
               "goes on with the map of utime " + std::to_string((*recovered)->info.last_utime));
      Start start{std::move((*recovered)->map), (*recovered)->info};
      if (auto same = same_resolution(start, config, node.state().path(kMapFile)); !same) {
        return tl::make_unexpected(same.error());
      }
      return start;
    }
  }
  if (config.map.empty()) return Start{mapping::VoxelMap(config.resolution_m, config.evidence), {}};
  auto loaded = mapping::load_map(config.map, config.evidence);
  if (!loaded) return tl::make_unexpected(loaded.error());
  Start start{std::move(loaded->map), loaded->info};
  if (auto same = same_resolution(start, config, config.map); !same)
    return tl::make_unexpected(same.error());
  return start;
}

std::unique_ptr<mapping::Integrator> integrator_of(const MapperConfig& config) {
  if (config.integration == "exact") return std::make_unique<mapping::RayIntegrator>(config.rays);
  return std::make_unique<mapping::ProjectiveIntegrator>(config.rays);
}

}  // namespace

Result<std::unique_ptr<MapperNode>> MapperNode::create(const Config& config, bus::Node& node) {
  auto start = starting_map(config, node);
  if (!start) return tl::make_unexpected(start.error());
  return std::make_unique<MapperNode>(config, std::move(start->map), start->info, node);
}

MapperNode::MapperNode(const Config& config, mapping::VoxelMap map, const mapping::MapInfo& info,
                       bus::Node& node)
    : config_{config},
      node_{node},
      map_{std::move(map)},
      info_{info},
      integrator_{integrator_of(config)},
      publisher_{map_, info.map_id, node} {
  if (config.pose == "POSE") {
    node.join<channels::Disparity, channels::Pose>(
        [this](const disparity_t& seen, const pose_t& from) { take_posed(seen, from); });
  } else {
    node.join<channels::Disparity, channels::Odometry>(
        [this](const disparity_t& seen, const odometry_t& from) { take_odometric(seen, from); });
  }
  node.on<channels::MapCommand>([this](const map_command_t& command) { obey(command); });
  if (node.state().enabled()) node.every_host(kJournalPeriod_us, [this] { keep_journal(); });
}

void MapperNode::take_posed(const disparity_t& seen, const pose_t& from) {
  if (auto good = messages::check(from); !good) {
    node_.refuse(channels::Pose::name, good.error().message);
  } else if (from.state == pose_t::STATE_TRACKING) {
    integrate(seen, from.T_map_body);
  } else {
    ++node_.counter("not_mapped_unsure_of_pose");
  }
  publisher_.frame_done(info_.map_id, seen.header.utime, std::exchange(changed_, {}));
}

void MapperNode::take_odometric(const disparity_t& seen, const odometry_t& from) {
  if (auto good = messages::check(from); !good) {
    node_.refuse(channels::Odometry::name, good.error().message);
  } else if (from.quality >= config_.min_quality) {
    integrate(seen, from.T_odom_body);
  } else {
    ++node_.counter("not_mapped_unsure_of_pose");
  }
  publisher_.frame_done(info_.map_id, seen.header.utime, std::exchange(changed_, {}));
}

void MapperNode::integrate(const disparity_t& seen, const isometry_t& pose) {
  if (!config_.integrate) return;
  const auto image = messages::to_disparity(seen);
  if (!image) return node_.refuse(channels::Disparity::name, image.error().message);
  const auto T_map_body = messages::to_isometry(pose, "pose");
  if (!T_map_body) return node_.refuse(config_.pose, T_map_body.error().message);
  auto integration =
      integrator_->integrate(*image, *T_map_body * image->camera.T_body_camera, map_);
  if (!integration) return node_.refuse(channels::Disparity::name, integration.error().message);
  if (info_.map_id == 0) {
    info_.map_id = mapping::make_map_id(static_cast<std::uint64_t>(seen.calibration_id),
                                        fnv1a_64(seen.packed));
  }
  info_.last_utime = image->utime;
  ++node_.counter("frames_mapped");
  node_.counter("occupied_voxels") = static_cast<std::int64_t>(map_.occupied_voxels());
  changed_ = std::move(integration->changed);
}

void MapperNode::obey(const map_command_t& command) {
  if (command.action != map_command_t::ACTION_SAVE) {
    return node_.refuse(channels::MapCommand::name, "only saving is possible while the robot runs");
  }
  const std::filesystem::path path =
      command.path.empty() ? node_.state().path(kMapFile) : std::filesystem::path(command.path);
  if (path.empty())
    return node_.refuse(channels::MapCommand::name, "names no file, and there is no state folder");
  const auto saved = mapping::save_map(path, map_, info_);
  if (!saved) return node_.refuse(channels::MapCommand::name, saved.error().message);
  node_.log(bus::Level::kInfo, "saved " + path.string());
}

void MapperNode::keep_journal() {
  if (info_.map_id == 0) return;
  Result<void> kept;
  if (!journal_ || journal_->bytes() > kLargestJournal_bytes) {
    auto started = mapping::MapJournal::start(node_.state().path(kMapFile), map_, info_, {});
    if (started) {
      journal_.emplace(std::move(*started));
    } else {
      kept = tl::make_unexpected(started.error());
    }
  } else if (auto appended = journal_->append(map_, info_, {}, node_.host_time()); !appended) {
    kept = tl::make_unexpected(appended.error());
  }
  node_.set_health(kept ? bus::Health::kOk : bus::Health::kIll, kept ? "" : kept.error().message);
}

// Folds the journal into the map file.
Result<void> MapperNode::finish() {
  if (!node_.state().enabled() || info_.map_id == 0) return {};
  auto folded = mapping::MapJournal::start(node_.state().path(kMapFile), map_, info_, {});
  if (!folded) return tl::make_unexpected(folded.error());
  return {};
}

}  // namespace cairn
