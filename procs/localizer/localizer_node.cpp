// SPDX-License-Identifier: Apache-2.0
#include "procs/localizer/localizer_node.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "localization/checkpoint.hpp"
#include "messages/check.hpp"
#include "messages/disparity_messages.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr const char* kCheckpoint = "localizer";
constexpr std::int64_t kParticlesPeriod_us = 250'000;
/// What people can look at.
constexpr std::size_t kMostShown = 500;
/// How sure somebody may be of where the robot is.
constexpr double kLeastSigma_m = 0.01;
constexpr double kLeastSigma_rad = 0.01;

Result<localization::OdometryFrame> to_frame(const odometry_t& message) {
  if (auto good = messages::check(message); !good) return tl::make_unexpected(good.error());
  auto pose = messages::to_isometry(message.T_odom_body, "T_odom_body");
  if (!pose) return tl::make_unexpected(pose.error());
  auto covariance = messages::to_covariance(message.covariance, "covariance");
  if (!covariance) return tl::make_unexpected(covariance.error());
  return localization::OdometryFrame{message.header.utime, *pose, *covariance, message.epoch};
}

}  // namespace

Result<std::unique_ptr<LocalizerNode>> LocalizerNode::create(const Config& config,
                                                             bus::Node& node) {
  return std::make_unique<LocalizerNode>(config, node);
}

LocalizerNode::LocalizerNode(const Config& config, bus::Node& node)
    : node_{node}, localizer_{config} {
  if (!config.correct) {
    node.on<channels::Odometry>([this](const odometry_t& odometry) { pass_on(odometry); });
    node.on<channels::LocalizerCommand>([this](const localizer_command_t&) {
      node_.refuse(channels::LocalizerCommand::name, "corrections are off (localizer.correct)");
    });
    return;
  }
  resume();
  node.on<channels::MapDelta>([this](const map_delta_t& delta) {
    if (auto put = map_.put(delta); !put)
      node_.refuse(channels::MapDelta::name, put.error().message);
  });
  node.on<channels::MapDigest>([this](const map_digest_t& digest) {
    if (auto put = map_.put(digest); !put)
      node_.refuse(channels::MapDigest::name, put.error().message);
  });
  node.on<channels::Odometry>([this](const odometry_t& odometry) {
    publish_pose(odometry);
    frames_.put_second(odometry);
    update();
  });
  node.on<channels::Disparity>([this](const disparity_t& seen) {
    frames_.put_first(seen);
    update();
  });
  node.on<channels::LocalizerCommand>(
      [this](const localizer_command_t& command) { obey(command); });
  node.every_data(kParticlesPeriod_us, [this] { show_particles(); });
}

void LocalizerNode::pass_on(const odometry_t& odometry) {
  if (auto good = messages::check(odometry); !good)
    return node_.refuse(channels::Odometry::name, good.error().message);
  pose_t pose{};
  pose.T_map_body = odometry.T_odom_body;
  pose.T_map_odom = messages::to_message(Isometry::Identity());
  pose.correction_utime = odometry.header.utime;
  pose.epoch = odometry.epoch;
  pose.state = pose_t::STATE_TRACKING;
  std::copy(std::begin(odometry.covariance), std::end(odometry.covariance),
            std::begin(pose.covariance));
  node_.publish<channels::Pose>(std::move(pose), odometry.header.utime);
}

void LocalizerNode::publish_pose(const odometry_t& odometry) {
  const auto frame = to_frame(odometry);
  if (!frame) return node_.refuse(channels::Odometry::name, frame.error().message);
  map_.note_frame(frame->utime);
  const auto pose = localizer_.move(*frame);
  const Isometry T_map_odom = messages::as_sent(pose.T_map_odom);
  T_map_body_ = T_map_odom * frame->T_odom_body;
  pose_t message{};
  message.T_map_body = messages::to_message(T_map_body_);
  message.T_map_odom = messages::to_message(T_map_odom);
  message.correction_utime = pose.correction_utime;
  message.epoch = odometry.epoch;
  message.state = static_cast<std::int8_t>(pose.certainty);
  messages::set_covariance(message.covariance, pose.covariance);
  node_.publish<channels::Pose>(message, frame->utime);
  ask_for_map();
  remember();
}

// POSE must not wait for DISPARITY, so ODOMETRY is listened to by itself, and joined here.
void LocalizerNode::update() {
  while (const auto frame = frames_.take()) update(frame->first);
}

void LocalizerNode::update(const disparity_t& seen) {
  const auto image = messages::to_disparity(seen);
  if (!image) return node_.refuse(channels::Disparity::name, image.error().message);
  map_.apply_for_frame(seen.header.utime);
  node_.counter("map_late") = map_.late();
  const auto update = localizer_.update(*image, map_.map(), map_.take_changes());
  if (update.known_frame && !update.in_time) ++node_.counter("correction_late");
  node_.counter("relocalised") = localizer_.relocalised();
}

void LocalizerNode::ask_for_map() {
  auto request = map_.next_request(node_.host_time(), node_.data_time(), T_map_body_.translation());
  if (request) node_.publish<channels::MapRequest>(std::move(*request), node_.data_time());
}

void LocalizerNode::obey(const localizer_command_t& command) {
  const auto refuse = [this](const std::string& why) {
    node_.refuse(channels::LocalizerCommand::name, why);
  };
  switch (command.action) {
    case localizer_command_t::ACTION_RESET:
      return localizer_.forget();
    case localizer_command_t::ACTION_START_POSE: {
      const auto pose = messages::to_isometry(command.T_map_body, "T_map_body");
      if (!pose) return refuse(pose.error().message);
      if (!(command.sigma_m >= 0 && std::isfinite(command.sigma_m)))
        return refuse("sigma_m: must be a number from 0 on");
      if (!(command.sigma_rad >= 0 && std::isfinite(command.sigma_rad)))
        return refuse("sigma_rad: must be a number from 0 on");
      return localizer_.start_at(*pose, std::max(command.sigma_m, kLeastSigma_m),
                                 std::max(command.sigma_rad, kLeastSigma_rad));
    }
    case localizer_command_t::ACTION_MODE:
      return refuse("action: whether the map grows is mapper's to say (mapper.integrate)");
    default:
      return refuse("action: " + std::to_string(command.action) + " is none");
  }
}

// Every so-many-th, so that their density shows.
void LocalizerNode::show_particles() {
  const auto particles = localizer_.filter().particles();
  if (particles.empty()) return;
  const std::size_t shown = std::min(particles.size(), kMostShown);
  double sum = 0;
  for (std::size_t i = 0; i < shown; ++i) sum += particles[i * particles.size() / shown].weight;
  particles_t message{};
  message.count = static_cast<std::int32_t>(shown);
  for (std::size_t i = 0; i < shown; ++i) {
    const localization::Particle& particle = particles[i * particles.size() / shown];
    message.x_m.push_back(static_cast<float>(particle.x_m));
    message.y_m.push_back(static_cast<float>(particle.y_m));
    message.z_m.push_back(static_cast<float>(particle.z_m));
    message.yaw_rad.push_back(static_cast<float>(particle.yaw_rad));
    message.weight.push_back(
        static_cast<float>(sum > 0 ? particle.weight / sum : 1.0 / static_cast<double>(shown)));
  }
  node_.publish<channels::Particles>(std::move(message), node_.data_time());
}

void LocalizerNode::resume() {
  const auto bytes = node_.state().load(kCheckpoint);
  if (!bytes) return;
  const auto memory = localization::memory_from_bytes(*bytes);
  if (!memory) {
    node_.log(bus::Level::kWarning, "the checkpoint is not used: " + memory.error().message);
    return;
  }
  localizer_.resume(*memory);
  node_.log(bus::Level::kInfo,
            "goes on from the pose at utime " + std::to_string(memory->frame.utime));
}

void LocalizerNode::remember() {
  const auto memory = localizer_.memory();
  if (!memory || !node_.state().enabled()) return;
  const auto saved = node_.state().save(kCheckpoint, localization::to_bytes(*memory));
  if (!saved) node_.log(bus::Level::kWarning, saved.error().message);
}

}  // namespace cairn
