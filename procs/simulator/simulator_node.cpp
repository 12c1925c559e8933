// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/simulator_node.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/time.hpp"
#include "messages/calibration_messages.hpp"
#include "messages/geometry_messages.hpp"
#include "procs/simulator/fast_senses.hpp"
#include "procs/simulator/feedback_gate.hpp"
#include "procs/simulator/paint_shop.hpp"
#include "procs/simulator/simulated_time.hpp"
#include "simulation/playground.hpp"
#include "simulation/pseudo_terminal.hpp"
#include "simulation/random_hash.hpp"
#include "simulation/wheel_controller.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

using simulation::Playground;
using simulation::WheelController;

constexpr std::int64_t kCalibrationPeriod_us = kMicrosecondsPerSecond;
/// At least so often CLOCK goes out: of data time while that goes on, of host time while it stands.
constexpr std::int64_t kClockPeriod_us = 40'000;
/// Time that stands still is nothing to speak of for so long.
constexpr HostTime kWaitsQuietly_us = kMicrosecondsPerSecond;

/// Everything that a run is made of; either pictures, or senses without pictures.
struct Parts {
  camera::RigCalibration rig;
  Playground playground;
  std::unique_ptr<PaintShop> pictures;
  std::unique_ptr<FastSenses> senses;
};

Result<void> add_pictures(const simulation::World& world, const SimulatorConfig& config,
                          std::uint64_t seed, PaintShop::Place place, Parts& parts) {
  auto renderer =
      simulation::Renderer::create(world, parts.rig, config.sensor, simulation::hash64(seed, 2));
  if (!renderer) return tl::make_unexpected(renderer.error());
  parts.pictures = std::make_unique<PaintShop>(
      FramePainter(std::move(*renderer), parts.rig.id, config.frame_budget_bytes), place);
  return {};
}

Result<void> add_senses(const simulation::World& world, std::uint64_t seed, Parts& parts) {
  auto disparity =
      simulation::DisparityModel::create(world, parts.rig, simulation::hash64(seed, 2));
  if (!disparity) return tl::make_unexpected(disparity.error());
  parts.senses = std::make_unique<FastSenses>(
      std::move(*disparity), simulation::OdometryModel(simulation::hash64(seed, 3)), parts.rig.id);
  return {};
}

Result<Parts> make_parts(const SimulatorConfig& config, PaintShop::Place place) {
  const auto loaded = simulation::load_world(config.world);
  if (!loaded) return tl::make_unexpected(loaded.error());
  const auto world = std::make_shared<const simulation::World>(*loaded);
  const auto rig_file = camera::load_rig(config.rig);
  if (!rig_file) return tl::make_unexpected(rig_file.error());
  auto rig = messages::as_sent(*rig_file);
  const auto seed = simulation::hash64(static_cast<std::uint64_t>(config.seed));
  auto playground =
      Playground::create(world, config.robot, config.tracks,
                         static_cast<std::size_t>(config.people), simulation::hash64(seed, 1));
  if (!playground) return fail(config.world + ": " + playground.error().message);
  Parts parts{std::move(rig), std::move(*playground), nullptr, nullptr};
  const auto added = config.fast ? add_senses(*world, seed, parts)
                                 : add_pictures(*world, config, seed, place, parts);
  if (!added) return fail(config.world + ": " + added.error().message);
  return parts;
}

}  // namespace

struct SimulatorNode::State {
  Config config;
  bus::Node& node;
  camera::RigCalibration rig;
  Playground playground;
  std::unique_ptr<PaintShop> pictures;
  std::unique_ptr<FastSenses> senses;
  std::unique_ptr<motor::ByteLink> wheel_line;
  WheelController controller;
  std::optional<FeedbackGate> gate;
  SimulatedTime time;
  Utime now = kStart_us;
  std::int64_t next_frame = 0;
  Utime last_clock = 0;
  HostTime last_clock_host_us = 0;
  std::optional<HostTime> waits_since_us;
  std::int64_t told_collisions = 0;

  State(const Config& settings, bus::Node& host, Parts parts, std::unique_ptr<motor::ByteLink> line,
        double speed);
  void listen_to_feedback();

  void tick();
  [[nodiscard]] bool take_frame();
  [[nodiscard]] bool must_wait();
  void step();
  void tell_collisions();
  void read_wheel_line();
  void report_wheels();
  void publish_painted();
  void publish_sensed(const Capture& capture);
  void publish_calibration();
  void publish_clock();
  void publish_truth();
  [[nodiscard]] Utime frame_due() const;
};

SimulatorNode::State::State(const Config& settings, bus::Node& host, Parts parts,
                            std::unique_ptr<motor::ByteLink> line, double speed)
    : config{settings},
      node{host},
      rig{std::move(parts.rig)},
      playground{std::move(parts.playground)},
      pictures{std::move(parts.pictures)},
      senses{std::move(parts.senses)},
      wheel_line{std::move(line)},
      controller{static_cast<std::uint32_t>(host.host_time() | 1)},
      time{speed, kStart_us, host.host_time()} {
  config.speed = speed;
  if (speed > 1) listen_to_feedback();
  node.set_data_time(now);
  publish_calibration();
  node.every_host(kCalibrationPeriod_us, [this] { publish_calibration(); });
  const auto step_us = static_cast<double>(Playground::kStep_us);
  node.every_host(static_cast<std::int64_t>(std::clamp(step_us / speed, 1'000.0, step_us)),
                  [this] { tick(); });
}

void SimulatorNode::State::listen_to_feedback() {
  gate.emplace(!config.fast);
  node.on<channels::Disparity>(
      [this](const disparity_t& m) { gate->hear_disparity(m.header.utime); });
  node.on<channels::Pose>([this](const pose_t& m) { gate->hear_pose(m.header.utime); });
  node.on<channels::MapDelta>(
      [this](const map_delta_t& m) { gate->hear_map(m.complete_through_utime); });
}

void SimulatorNode::State::tick() {
  read_wheel_line();
  publish_painted();
  const Utime due = time.due(now, node.host_time());
  node.counter("time_lost_us") = time.lost_us();
  while (true) {
    if (now >= frame_due() && !take_frame()) {
      time.hold(now, node.host_time());
      break;
    }
    if (now + Playground::kStep_us > due) break;
    step();
  }
  if (now - last_clock >= kClockPeriod_us ||
      node.host_time() - last_clock_host_us >= kClockPeriod_us) {
    publish_clock();
  }
}

// Frames are taken at the first step when they are due, so that their utime is when they were
// taken.
Utime SimulatorNode::State::frame_due() const {
  return kStart_us + static_cast<Utime>(static_cast<double>(next_frame) * 1e6 / config.rate_hz);
}

bool SimulatorNode::State::take_frame() {
  if (must_wait()) return false;
  const bool keeps_up = !pictures || pictures->has_room();
  if (!keeps_up && gate) return false;
  if (gate) gate->frame_taken(now);
  publish_clock();
  if (config.publish_truth) publish_truth();
  const auto people = playground.people();
  const Capture capture{
      now, next_frame++, playground.body().T_world_body(), {people.begin(), people.end()}};
  if (senses) {
    publish_sensed(capture);
  } else if (keeps_up) {
    pictures->order(capture);
    publish_painted();
  } else {
    ++node.counter("frames_not_painted");
  }
  return true;
}

void SimulatorNode::State::publish_sensed(const Capture& capture) {
  node.publish<channels::Odometry>(senses->odometry(capture), capture.utime);
  auto disparity = senses->disparity(capture);
  if (!disparity) return node.refuse(channels::Disparity::name, disparity.error().message);
  node.publish<channels::Disparity>(std::move(*disparity), capture.utime);
}

bool SimulatorNode::State::must_wait() {
  if (!gate) return false;
  const auto missing = gate->waits_for(node.host_time());
  if (!missing) {
    waits_since_us.reset();
    node.set_health(bus::Health::kOk, "");
    return false;
  }
  if (!waits_since_us) waits_since_us = node.host_time();
  if (node.host_time() - *waits_since_us > kWaitsQuietly_us)
    node.set_health(bus::Health::kWaiting, "time stands still until there is " + *missing);
  return true;
}

void SimulatorNode::State::step() {
  const auto duty = controller.duty(node.host_time());
  playground.step(duty.left, duty.right);
  now += Playground::kStep_us;
  if (config.publish_truth) tell_collisions();
  if ((now - kStart_us) % WheelController::kReportPeriod_us == 0) report_wheels();
}

void SimulatorNode::State::tell_collisions() {
  const auto& body = playground.body();
  if (body.collisions() == told_collisions) return;
  told_collisions = body.collisions();
  node.log(bus::Level::kInfo, body.fallen() ? std::string("the robot fell over an edge")
                                            : "the robot ran into " + body.last_collision());
}

void SimulatorNode::State::read_wheel_line() {
  const auto bytes = wheel_line->read();
  if (!bytes) {
    ++node.counter("wheel_line_cut");
    return;
  }
  controller.receive(*bytes, node.host_time());
}

void SimulatorNode::State::report_wheels() {
  const auto& body = playground.body();
  const auto report =
      controller.report(body.left_ticks(), body.right_ticks(), now - kStart_us, node.host_time());
  if (!wheel_line->write(report.bytes())) ++node.counter("wheel_reports_unread");
}

void SimulatorNode::State::publish_painted() {
  if (!pictures) return;
  for (auto& frame : pictures->take()) {
    if (!frame) {
      node.refuse(channels::StereoFrame::name, frame.error().message);
      continue;
    }
    const Utime utime = frame->header.utime;
    node.publish<channels::StereoFrame>(std::move(*frame), utime);
  }
}

void SimulatorNode::State::publish_calibration() {
  node.publish<channels::Calibration>(messages::to_message(rig, now), now);
}

void SimulatorNode::State::publish_clock() {
  node.set_data_time(now);
  last_clock = now;
  last_clock_host_us = node.host_time();
  cairn::clock_t tick{};
  tick.rate = config.speed;
  node.publish<channels::Clock>(tick, now);
}

void SimulatorNode::State::publish_truth() {
  const auto& body = playground.body();
  pose_t pose{};
  pose.T_map_body = messages::to_message(body.T_world_body());
  pose.T_map_odom = messages::to_message(Isometry::Identity());
  pose.correction_utime = now;
  pose.state = pose_t::STATE_TRACKING;
  node.publish<channels::Truth>(std::move(pose), now);
  sim_state_t state{};
  state.contacts = body.contacts();
  state.collisions = body.collisions();
  state.left_track_mps = body.left_hold().ground_mps;
  state.right_track_mps = body.right_hold().ground_mps;
  state.left_slip = body.left_hold().slip;
  state.right_slip = body.right_hold().slip;
  node.publish<channels::SimState>(state, now);
}

Result<void> SimulatorNode::check(const Config& config) {
  if (config.world.empty()) return fail("simulator.world: names no world file");
  return {};
}

Result<std::unique_ptr<SimulatorNode>> SimulatorNode::create(const Config& config,
                                                             bus::Node& node) {
  if (auto good = check(config); !good) return tl::make_unexpected(good.error());
  if (config.wheel_device.empty())
    return fail("simulator.wheel_device: names no link to make to the wheel controller");
  auto parts = make_parts(config, PaintShop::Place::kOwnThread);
  if (!parts) return tl::make_unexpected(parts.error());
  auto line = simulation::PseudoTerminal::open(config.wheel_device);
  if (!line) return tl::make_unexpected(line.error());
  return std::unique_ptr<SimulatorNode>(new SimulatorNode(
      std::make_unique<State>(config, node, std::move(*parts), std::move(*line), config.speed)));
}

Result<std::unique_ptr<SimulatorNode>> SimulatorNode::create_for_lockstep(
    const Config& config, bus::Node& node, std::unique_ptr<motor::ByteLink> wheel_line) {
  if (auto good = check(config); !good) return tl::make_unexpected(good.error());
  auto parts = make_parts(config, PaintShop::Place::kHere);
  if (!parts) return tl::make_unexpected(parts.error());
  return std::unique_ptr<SimulatorNode>(new SimulatorNode(
      std::make_unique<State>(config, node, std::move(*parts), std::move(wheel_line), 1)));
}

SimulatorNode::SimulatorNode(std::unique_ptr<State> state) : state_{std::move(state)} {}
SimulatorNode::~SimulatorNode() = default;

}  // namespace cairn
