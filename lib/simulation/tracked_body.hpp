// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/robot.hpp"
#include "simulation/body_shape.hpp"
#include "simulation/near_boxes.hpp"
#include "simulation/person_pose.hpp"
#include "simulation/track_drive.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// The robot's body on its tracks. It turns as tracks do, by their difference over a gauge that is
/// wider than theirs (Martinez et al. 2005, eq. 1); it stands on what is below it; what it runs
/// into stops it, or turns its way aside, and is never run through. Its tracks go on turning then,
/// for they slip. Once its middle is over an edge it has fallen: that is a contact, and it moves no
/// more. The same arguments give the same motion.
class TrackedBody {
 public:
  /// How fast a robot must move for a contact to count as a collision.
  static constexpr double kCollision_mps = 0.05;

  /// At the world's start. Fails where it does not fit there, or nothing carries it.
  [[nodiscard]] static Result<TrackedBody> create(std::shared_ptr<const World> world,
                                                  const RobotConfig& robot,
                                                  const TracksConfig& tracks, std::uint64_t seed,
                                                  std::span<const PersonPose> people = {});

  /// Duties are shares of full drive, -1 to 1. `people` are where they are at the end of the step.
  void step(double left_duty, double right_duty, double dt_s, std::span<const PersonPose> people);

  [[nodiscard]] const Isometry& T_world_body() const { return T_world_body_; }
  /// Whether somebody who stood so would be in it.
  [[nodiscard]] bool would_hold(const PersonPose& person) const;
  /// Of its fastest point, in the last step.
  [[nodiscard]] double fastest_mps() const { return fastest_mps_; }

  [[nodiscard]] std::int64_t left_ticks() const;
  [[nodiscard]] std::int64_t right_ticks() const;

  /// Things and people that it touches now; a fall counts as one.
  [[nodiscard]] int contacts() const;
  /// Contacts begun so far while it moved at over kCollision_mps.
  [[nodiscard]] std::int64_t collisions() const { return collisions_; }
  /// Name of what it last collided with; empty: of nothing yet, or of an edge that it fell from.
  [[nodiscard]] const std::string& last_collision() const { return last_collision_; }
  [[nodiscard]] bool fallen() const { return fallen_; }

  /// What a track does on the ground.
  struct Hold {
    double ground_mps = 0;  ///< of the body at the track, along it
    double slip = 0;        ///< share of the track's motion that is lost; 0 for a track that stands
  };
  [[nodiscard]] const Hold& left_hold() const { return left_hold_; }
  [[nodiscard]] const Hold& right_hold() const { return right_hold_; }

 private:
  /// A box (its place in the world) or, beyond the boxes, somebody.
  using Obstacle = std::size_t;
  struct Place {
    Eigen::Vector2d at_m;
    double yaw;
  };
  /// How an attempt to get somewhere came out.
  struct Attempt {
    Place place;
    Isometry T_world_body;
    std::vector<Obstacle> pushed_by;
    bool free = false;  ///< there is a place, in nothing
    bool fell = false;
  };

  TrackedBody(std::shared_ptr<const World> world, const RobotConfig& robot,
              const TracksConfig& tracks, std::uint64_t seed);

  [[nodiscard]] const std::string& name_of(Obstacle obstacle) const;
  [[nodiscard]] Place driven(double dt_s) const;
  [[nodiscard]] Attempt attempt(Place place, std::span<const PersonPose> people);
  [[nodiscard]] Attempt go_or_stay(Place wanted, std::span<const PersonPose> people);
  void touch(const Attempt& attempt, std::span<const PersonPose> people);
  void collide(const std::string& name);
  void measure_motion(const Place& before, double dt_s);
  /// Calls `look(obstacle, contact)` for all that is near.
  template <class Look>
  void for_each_near(const Isometry& T_world_body, std::span<const PersonPose> people, Look&& look);

  std::shared_ptr<const World> world_;
  RobotConfig robot_;
  double effective_gauge_m_;
  BodyShape shape_;
  NearBoxes near_;
  TrackDrive left_;
  TrackDrive right_;
  Place place_;
  Isometry T_world_body_;
  double fastest_mps_ = 0;
  Hold left_hold_;
  Hold right_hold_;
  std::vector<Obstacle> touching_;  ///< in rising order
  std::int64_t collisions_ = 0;
  std::string last_collision_;
  bool fallen_ = false;
};

}  // namespace cairn::simulation
