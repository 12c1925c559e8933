// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/result.hpp"
#include "core/robot.hpp"
#include "simulation/people.hpp"
#include "simulation/tracked_body.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// A world with its people and a robot's body in it, moved on in steps of one length. The same
/// arguments and duties give the same motion.
class Playground {
 public:
  static constexpr std::int64_t kStep_us = 5'000;

  /// Errors name the key of the world that does not serve.
  [[nodiscard]] static Result<Playground> create(std::shared_ptr<const World> world,
                                                 const RobotConfig& robot,
                                                 const TracksConfig& tracks, std::size_t people,
                                                 std::uint64_t seed);

  /// By kStep_us. Duties are shares of full drive, -1 to 1.
  void step(double left_duty, double right_duty);

  [[nodiscard]] const TrackedBody& body() const { return body_; }
  [[nodiscard]] std::span<const PersonPose> people() const { return people_.poses(); }

 private:
  Playground(TrackedBody body, People people)
      : body_{std::move(body)}, people_{std::move(people)} {}

  TrackedBody body_;
  People people_;
};

}  // namespace cairn::simulation
