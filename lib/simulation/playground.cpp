// SPDX-License-Identifier: Apache-2.0
#include "simulation/playground.hpp"

#include <utility>

#include "core/time.hpp"
#include "simulation/random_hash.hpp"

namespace cairn::simulation {

Result<Playground> Playground::create(std::shared_ptr<const World> world, const RobotConfig& robot,
                                      const TracksConfig& tracks, std::size_t people,
                                      std::uint64_t seed) {
  auto walkers = People::create(*world, people, hash64(seed, 1));
  if (!walkers) return tl::make_unexpected(walkers.error());
  auto body =
      TrackedBody::create(std::move(world), robot, tracks, hash64(seed, 2), walkers->poses());
  if (!body) return tl::make_unexpected(body.error());
  return Playground{std::move(*body), std::move(*walkers)};
}

void Playground::step(double left_duty, double right_duty) {
  constexpr double kStep_s = to_seconds(kStep_us);
  people_.step(kStep_s, body_.T_world_body().translation().head<2>(), body_.fastest_mps(),
               [this](const PersonPose& person) { return body_.would_hold(person); });
  body_.step(left_duty, right_duty, kStep_s, people_.poses());
}

}  // namespace cairn::simulation
