// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/result.hpp"
#include "simulation/world.hpp"

namespace cairn::testing {

/// A place that nobody laid out, as a world file that follows config/worlds/README.md alone: one to
/// six rooms with doors, furniture where it fell, tables on legs, two people on rounds that are
/// free. The same seed gives the same text.
[[nodiscard]] std::string random_world_yaml(unsigned seed);

/// That text, through a file.
[[nodiscard]] Result<simulation::World> random_world(unsigned seed);

}  // namespace cairn::testing
