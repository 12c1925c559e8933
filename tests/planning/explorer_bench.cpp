// SPDX-License-Identifier: Apache-2.0
#include "explorer_bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <utility>

namespace cairn::testing {
namespace {

using simulation::Playground;

constexpr double kFrame_s = 1.0 / 15;
constexpr std::int64_t kMotorPeriod_us = 20'000;
constexpr std::int64_t kGuardPeriod_us = 50'000;
constexpr std::int64_t kCommandPeriod_us = 50'000;
constexpr std::int64_t kDisparityTakes_us = 70'000;
constexpr std::int64_t kOdometryTakes_us = 40'000;
constexpr std::int64_t kBusTakes_us = 5'000;
constexpr std::int64_t kLineTakes_us = 10'000;
constexpr std::int64_t kMapTakes_frames = 8;
constexpr double kMaxSightAge_s = 0.4;
constexpr double kNearby_m = 2;

/// Of this thread, so that others on the machine do not count.
double processor_ms() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// The simulated robot's cameras on its body: 60 degrees wide, level, 0.30 m high, 25.4 cm apart.
camera::RigCalibration bench_rig() {
  constexpr double kBaseline_m = 0.254;
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0, kBaseline_m / 2, 0.30);
  const double f_px = 320 / std::tan(std::numbers::pi / 6);
  return camera::rectified_rig(f_px, f_px, 319.5, 239.5, kBaseline_m, 640, 480, T_body_left);
}

double milliseconds_of(const std::function<void()>& work) {
  const double from_ms = processor_ms();
  work();
  return processor_ms() - from_ms;
}

}  // namespace

ExplorerBench::ExplorerBench(const simulation::World& world, const BenchConfig& config,
                             const planning::NavigatorConfig& navigation)
    : config_{config},
      navigation_{navigation},
      world_{std::make_shared<const simulation::World>(world)},
      T_map_world_{world.T_world_start.inverse()},
      pose_{config.pose, config.seed + 1},
      map_{std::make_unique<mapping::VoxelMap>(config.resolution_m)},
      integrator_{mapping::RayIntegratorConfig{}},
      tracks_{robot_,
              {.effective_gauge_ratio =
                   simulation::TracksConfig{}.effective_gauge_ratio * config.gauge_error}},
      guard_{{}, robot_},
      navigator_{std::make_unique<planning::Navigator>(navigation, robot_)},
      left_{motor::TrackPid({}, robot_.max_acceleration_mps2),
            motor::TrackSpeed(robot_.ticks_per_m)},
      right_{left_} {
  make_playground();
  open_eyes();
  const auto start_m = world.T_world_start.translation().head<2>();
  sight_ = std::make_unique<simulation::FloorSight>(
      std::move(simulation::FloorSight::create(
                    world, bench_rig(), robot_,
                    simulation::ReachableFloor::flood(world, start_m, {}).value(), {})
                    .value()));
}

void ExplorerBench::make_playground() {
  playground_ = std::make_unique<Playground>(std::move(
      Playground::create(world_, robot_, {}, static_cast<std::size_t>(config_.people), config_.seed)
          .value()));
}

void ExplorerBench::open_eyes() {
  eyes_ = std::make_unique<simulation::DisparityModel>(
      std::move(simulation::DisparityModel::create(*world_, bench_rig(), config_.seed).value()));
}

void ExplorerBench::put(const simulation::Box& box) {
  auto world = std::make_shared<simulation::World>(*world_);
  world->boxes.push_back(box);
  world->T_world_start = playground_->body().T_world_body();
  collisions_before_ += playground_->body().collisions();
  left_ticks_before_ += playground_->body().left_ticks();
  right_ticks_before_ += playground_->body().right_ticks();
  world_ = std::move(world);
  make_playground();
  open_eyes();
}

void ExplorerBench::forget_map() {
  map_ = std::make_unique<mapping::VoxelMap>(config_.resolution_m);
  ++map_id_;
}

void ExplorerBench::restart_planner() {
  const planning::PlanMemory memory = navigator_->memory();
  navigator_ = std::make_unique<planning::Navigator>(navigation_, robot_);
  navigator_->restore(memory);
  replica_ = {};
  // It asks for the map anew.
  std::vector<mapping::BrickIndex> all;
  map_->grid().for_each([&](mapping::BrickIndex brick, const auto&) { all.push_back(brick); });
  deltas_.push_back({frame_, mapping::make_delta(*map_, map_id_, now_, all)});
}

planning::Pose2 ExplorerBench::in_world() const {
  return planning::from_above(playground_->body().T_world_body());
}

Eigen::Vector2d ExplorerBench::to_map_m(const Eigen::Vector2d& point_world_m) const {
  return (T_map_world_ * Eigen::Vector3d(point_world_m.x(), point_world_m.y(), 0)).head<2>();
}

void ExplorerBench::later(std::int64_t after_us, Work work) {
  due_.push_back({now_ + after_us, std::move(work)});
}

void ExplorerBench::take_frame() {
  const Isometry T_world_body = playground_->body().T_world_body();
  sight_->look(T_world_body);
  pose_.move(T_map_world_ * T_world_body, kFrame_s);
  auto image = eyes_->see(T_world_body, frame_, now_, playground_->people());
  map(image, pose_.T_map_body());
  later(kDisparityTakes_us, [this, image = std::move(image)]() mutable { see(std::move(image)); });
  planning::Situation situation;
  situation.utime = now_;
  situation.in_odom = pose_.in_odom();
  const auto& body = playground_->body();
  situation.forward_mps = 0.5 * (body.left_hold().ground_mps + body.right_hold().ground_mps);
  situation.turn_radps =
      (body.right_hold().ground_mps - body.left_hold().ground_mps) / robot_.track_gauge_m;
  situation.T_map_odom = pose_.T_map_odom();
  situation.height_m = pose_.T_map_body().translation().z();
  situation.located = true;
  later(kOdometryTakes_us, [this, situation] { plan(situation); });
  ++frame_;
}

void ExplorerBench::map(const stereo::DisparityImage& image, const Isometry& T_map_body) {
  const auto integration =
      integrator_.integrate(image, T_map_body * image.camera.T_body_camera, *map_).value();
  deltas_.push_back(
      {frame_ + kMapTakes_frames, mapping::make_delta(*map_, map_id_, now_, integration.changed)});
}

void ExplorerBench::see(stereo::DisparityImage image) {
  const auto moment = tracks_.at(image.utime);
  if (!moment) return;
  cost_.guard_ms.push_back(milliseconds_of([&] { guard_.see(image, moment->T_start_body); }));
  seen_utime_ = image.utime;
}

void ExplorerBench::judge() {
  const auto newest = tracks_.newest();
  permission_ = {0, "nothing yet"};
  if (newest && to_seconds(now_ - seen_utime_) <= kMaxSightAge_s) {
    const double measured_radps =
        (newest->reading.right_mps - newest->reading.left_mps) / tracks_.gauge_m();
    const double commanded_radps = (right_.commanded_mps - left_.commanded_mps) / tracks_.gauge_m();
    cost_.guard_ms.push_back(milliseconds_of([&] {
      permission_ = guard_.judge(now_, newest->T_start_body, measured_radps);
      auto other = guard_.judge(now_, newest->T_start_body, commanded_radps);
      if (other.max_forward_mps < permission_.max_forward_mps) permission_ = std::move(other);
    }));
  }
  later(kBusTakes_us,
        [this, mps = permission_.max_forward_mps] { permitted_mps_ = told_mps_ = mps; });
}

void ExplorerBench::plan(const planning::Situation& told) {
  while (!deltas_.empty() && deltas_.front().frame < frame_) {
    (void)replica_.apply(deltas_.front().delta).value();
    deltas_.pop_front();
  }
  planning::Situation situation = told;
  situation.allowed_mps = told_mps_;
  situation.map_through = replica_.utime();
  situation.map_whole = true;
  if (meddle) meddle(situation);
  const auto changes = replica_.take_changes();
  cost_.planner_ms.push_back(
      milliseconds_of([&] { navigator_->step(situation, replica_, changes); }));
  command();
  write_diary();
}

void ExplorerBench::command() {
  later(kBusTakes_us, [this, drive = navigator_->drive(now_)] { command_ = drive; });
}

// As motor's gate limits: the turn is kept and the speed gives way.
void ExplorerBench::drive_tracks() {
  const auto& body = playground_->body();
  const std::int64_t left_ticks = left_ticks_before_ + body.left_ticks();
  const std::int64_t right_ticks = right_ticks_before_ + body.right_ticks();
  left_.speed.add(now_, left_ticks);
  right_.speed.add(now_, right_ticks);
  const double half_m = robot_.track_gauge_m / 2;
  const double turn =
      std::clamp(command_.turn_radps, -robot_.max_turn_radps, robot_.max_turn_radps);
  const double room = robot_.max_speed_mps - std::abs(turn) * half_m;
  const double forward = std::clamp(std::min(command_.forward_mps, permitted_mps_), -room, room);
  left_.commanded_mps = forward - turn * half_m;
  right_.commanded_mps = forward + turn * half_m;
  tracks_.add(
      {now_, left_ticks, right_ticks, robot_.ticks_per_m, left_.speed.mps(), right_.speed.mps()});
  for (Track* track : {&left_, &right_}) {
    const double duty =
        track->pid.step(track->commanded_mps, track->speed.mps(), to_seconds(kMotorPeriod_us));
    later(kLineTakes_us, [track, duty] { track->duty = duty; });
  }
}

void ExplorerBench::note(const std::string& line) {
  const planning::Pose2 at = in_world();
  char text[400];
  std::snprintf(text, sizeof text, "%6.1f s (%.2f, %.2f) %.0f deg: %s [%s]", time_s(), at.at_m.x(),
                at.at_m.y(), at.heading_rad * 180 / std::numbers::pi, line.c_str(),
                permission_.reason.c_str());
  std::string entry = text;
  for (const auto& person : people()) {
    const Eigen::Vector2d ahead_m = planning::moved(planning::inverse(at), {person.at_m, 0}).at_m;
    if (ahead_m.norm() > kNearby_m) continue;
    std::snprintf(text, sizeof text, "; somebody at (%.2f, %.2f)", ahead_m.x(), ahead_m.y());
    entry += text;
  }
  diary_.push_back(entry);
}

void ExplorerBench::write_diary() {
  const planning::PlanReport& report = navigator_->report();
  if (report.reason == last_said_) return;
  last_said_ = report.reason;
  note(report.reason);
}

std::string ExplorerBench::story() const {
  std::string text;
  for (const std::string& line : diary_) text += line + "\n";
  return text;
}

void ExplorerBench::do_what_is_due() {
  const auto is_due = [this](const Due& due) { return due.at <= now_; };
  const auto later = std::stable_partition(due_.begin(), due_.end(), is_due);
  std::vector<Due> ready(std::make_move_iterator(due_.begin()), std::make_move_iterator(later));
  due_.erase(due_.begin(), later);
  std::stable_sort(ready.begin(), ready.end(),
                   [](const Due& a, const Due& b) { return a.at < b.at; });
  for (const Due& due : ready) due.work();
}

void ExplorerBench::step() {
  const std::int64_t until = frame_ + 1;
  while (frame_ < until) {
    do_what_is_due();
    const std::int64_t since_us = now_ - kStart;
    if (since_us % kMotorPeriod_us == 0) drive_tracks();
    if (since_us % kGuardPeriod_us == 0) judge();
    if (since_us % kCommandPeriod_us == 0) command();
    if (static_cast<double>(since_us) >= 1e6 * kFrame_s * static_cast<double>(frame_)) take_frame();
    playground_->step(left_.duty, right_.duty);
    now_ += Playground::kStep_us;
    const auto& body = playground_->body();
    driven_m_ += 0.5 * std::abs(body.left_hold().ground_mps + body.right_hold().ground_mps) *
                 to_seconds(Playground::kStep_us);
    if (collisions() > last_collisions_) {
      last_collisions_ = collisions();
      char text[120];
      std::snprintf(text, sizeof text, "COLLISION at %.2f m/s, commanded %.2f m/s and %.2f rad/s",
                    body.fastest_mps(), command_.forward_mps, command_.turn_radps);
      note(text);
    }
  }
}

void ExplorerBench::run(double at_most_s) {
  const double until_s = time_s() + at_most_s;
  do {
    step();
  } while (!navigator_->idle() && time_s() < until_s);
}

}  // namespace cairn::testing
