// SPDX-License-Identifier: Apache-2.0
#include "simulation/tracked_body.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "simulation/random_hash.hpp"

namespace cairn::simulation {
namespace {

/// Pushed out of something, the body comes to lie this far off it.
constexpr double kSkin_m = 1e-6;
/// Nearer than this it touches; farther than the second it no longer does.
constexpr double kTouch_m = 1e-4;
constexpr double kLetGo_m = 5e-3;
/// In a narrow corner pushes may chase each other; then the body stays where it was.
constexpr int kPushes = 12;
/// A track slower than this stands.
constexpr double kStands_mps = 0.01;

std::int64_t ticks(const TrackDrive& track, double ticks_per_m) {
  return static_cast<std::int64_t>(std::floor(track.way_m() * ticks_per_m));
}

}  // namespace

TrackedBody::TrackedBody(std::shared_ptr<const World> world, const RobotConfig& robot,
                         const TracksConfig& tracks, std::uint64_t seed)
    : world_{std::move(world)},
      robot_{robot},
      effective_gauge_m_{robot.track_gauge_m * tracks.effective_gauge_ratio},
      shape_{robot},
      near_{world_, shape_.reach_m()},
      left_{tracks, tracks.left_slip, hash64(seed, 1)},
      right_{tracks, tracks.right_slip, hash64(seed, 2)},
      place_{world_->T_world_start.translation().head<2>(), yaw_rad(world_->T_world_start)},
      T_world_body_{world_->T_world_start} {}

Result<TrackedBody> TrackedBody::create(std::shared_ptr<const World> world,
                                        const RobotConfig& robot, const TracksConfig& tracks,
                                        std::uint64_t seed, std::span<const PersonPose> people) {
  TrackedBody body(std::move(world), robot, tracks, seed);
  const Stance stance = stand_on(body.near_.at(body.place_.at_m), body.shape_.tracks(),
                                 body.T_world_body_, body.place_.at_m, body.place_.yaw);
  if (stance.tipped) return fail("start.at_m: there is no floor there that carries the robot");
  body.T_world_body_ = stance.T_world_body;
  std::string in_the_way;
  body.for_each_near(stance.T_world_body, people, [&](Obstacle obstacle, const Contact& contact) {
    if (contact.gap_m < 0) in_the_way = body.name_of(obstacle);
  });
  if (!in_the_way.empty()) return fail("start.at_m: the robot would stand in '" + in_the_way + "'");
  return body;
}

const std::string& TrackedBody::name_of(Obstacle obstacle) const {
  const std::size_t boxes = world_->boxes.size();
  return obstacle < boxes ? world_->boxes[obstacle].name : world_->people[obstacle - boxes].name;
}

bool TrackedBody::would_hold(const PersonPose& person) const {
  if (person.person >= world_->people.size()) return false;
  const Person& who = world_->people[person.person];
  const Eigen::Vector2d between_m = T_world_body_.translation().head<2>() - person.at_m;
  return between_m.norm() < shape_.reach_m() + who.radius_m &&
         shape_.with_person(T_world_body_, who, person).gap_m < 0;
}

template <class Look>
void TrackedBody::for_each_near(const Isometry& T_world_body, std::span<const PersonPose> people,
                                Look&& look) {
  for (const Box* box : near_.at(T_world_body.translation().head<2>())) {
    look(static_cast<Obstacle>(box - world_->boxes.data()), shape_.with_box(T_world_body, *box));
  }
  for (const PersonPose& person : people) {
    if (person.person >= world_->people.size()) continue;
    const Person& who = world_->people[person.person];
    const Eigen::Vector2d between_m = T_world_body.translation().head<2>() - person.at_m;
    if (between_m.norm() > shape_.reach_m() + who.radius_m) continue;
    look(world_->boxes.size() + person.person, shape_.with_person(T_world_body, who, person));
  }
}

void TrackedBody::step(double left_duty, double right_duty, double dt_s,
                       std::span<const PersonPose> people) {
  left_.step(left_duty, dt_s);
  right_.step(right_duty, dt_s);
  const Place before = place_;
  if (!fallen_) {
    const Attempt reached = go_or_stay(driven(dt_s), people);
    touch(reached, people);
    place_ = reached.place;
    T_world_body_ = reached.T_world_body;
    fallen_ = reached.fell;
  }
  measure_motion(before, dt_s);
}

// Along an arc of a circle; up a slope the way in plan is shorter.
TrackedBody::Place TrackedBody::driven(double dt_s) const {
  const double turn = (right_.ground_mps() - left_.ground_mps()) / effective_gauge_m_ * dt_s;
  const double arc_m = 0.5 * (left_.ground_mps() + right_.ground_mps()) * dt_s;
  const double half = 0.5 * turn;
  const double chord_m = std::abs(half) < 1e-9 ? arc_m : arc_m * std::sin(half) / half;
  const double level = T_world_body_.linear().col(0).head<2>().norm();
  const double heading = place_.yaw + half;
  return {place_.at_m + level * chord_m * Eigen::Vector2d(std::cos(heading), std::sin(heading)),
          place_.yaw + turn};
}

TrackedBody::Attempt TrackedBody::go_or_stay(Place wanted, std::span<const PersonPose> people) {
  Attempt whole = attempt(wanted, people);
  if (whole.free || whole.fell) return whole;
  for (const Place& part : {Place{wanted.at_m, place_.yaw}, Place{place_.at_m, wanted.yaw}}) {
    Attempt other = attempt(part, people);
    if (other.free) return other;
  }
  whole.place = place_;
  whole.T_world_body = T_world_body_;
  return whole;
}

TrackedBody::Attempt TrackedBody::attempt(Place place, std::span<const PersonPose> people) {
  Attempt result{place, T_world_body_, {}};
  for (int push = 0; push <= kPushes; ++push) {
    const Stance stance = stand_on(near_.at(result.place.at_m), shape_.tracks(), T_world_body_,
                                   result.place.at_m, result.place.yaw);
    if (stance.tipped) {
      result.place = place_;
      result.T_world_body = T_world_body_;
      result.fell = true;
      return result;
    }
    result.T_world_body = stance.T_world_body;
    Contact deepest;
    Obstacle by = 0;
    for_each_near(stance.T_world_body, people, [&](Obstacle obstacle, const Contact& contact) {
      if (contact.gap_m >= deepest.gap_m) return;
      deepest = contact;
      by = obstacle;
    });
    if (deepest.gap_m >= 0) {
      result.free = true;
      return result;
    }
    result.pushed_by.push_back(by);
    result.place.at_m += (kSkin_m - deepest.gap_m) * deepest.away;
  }
  return result;
}

void TrackedBody::touch(const Attempt& attempt, std::span<const PersonPose> people) {
  std::vector<Obstacle> still;
  std::vector<Obstacle> begun = attempt.pushed_by;
  for_each_near(attempt.T_world_body, people, [&](Obstacle obstacle, const Contact& contact) {
    if (contact.gap_m > kLetGo_m) return;
    if (std::binary_search(touching_.begin(), touching_.end(), obstacle)) {
      still.push_back(obstacle);
    } else if (contact.gap_m < kTouch_m) {
      begun.push_back(obstacle);
    }
  });
  std::sort(begun.begin(), begun.end());
  begun.erase(std::unique(begun.begin(), begun.end()), begun.end());
  for (const Obstacle obstacle : begun) {
    if (std::binary_search(touching_.begin(), touching_.end(), obstacle)) continue;
    still.push_back(obstacle);
    if (fastest_mps_ > kCollision_mps) collide(name_of(obstacle));
  }
  if (attempt.fell && fastest_mps_ > kCollision_mps) collide("");
  std::sort(still.begin(), still.end());
  touching_ = std::move(still);
}

void TrackedBody::collide(const std::string& name) {
  ++collisions_;
  last_collision_ = name;
}

void TrackedBody::measure_motion(const Place& before, double dt_s) {
  const Eigen::Vector2d moved_m = place_.at_m - before.at_m;
  const double turn = place_.yaw - before.yaw;
  fastest_mps_ = moved_m.norm() / dt_s +
                 std::abs(turn) / dt_s * 0.5 * std::hypot(robot_.length_m, robot_.width_m);
  const double heading = before.yaw + 0.5 * turn;
  const double level = T_world_body_.linear().col(0).head<2>().norm();
  const double along_mps =
      moved_m.dot(Eigen::Vector2d(std::cos(heading), std::sin(heading))) / level / dt_s;
  const auto hold = [&](const TrackDrive& track, double side) {
    Hold result;
    result.ground_mps = along_mps + side * 0.5 * robot_.track_gauge_m * turn / dt_s;
    if (std::abs(track.mps()) > kStands_mps) result.slip = 1 - result.ground_mps / track.mps();
    return result;
  };
  left_hold_ = hold(left_, -1);
  right_hold_ = hold(right_, 1);
}

std::int64_t TrackedBody::left_ticks() const { return ticks(left_, robot_.ticks_per_m); }
std::int64_t TrackedBody::right_ticks() const { return ticks(right_, robot_.ticks_per_m); }

int TrackedBody::contacts() const { return static_cast<int>(touching_.size()) + (fallen_ ? 1 : 0); }

}  // namespace cairn::simulation
