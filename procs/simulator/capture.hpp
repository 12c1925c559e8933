// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.hpp"
#include "core/time.hpp"
#include "simulation/person_pose.hpp"

namespace cairn {

/// How everything stood when a frame was taken.
struct Capture {
  Utime utime = 0;
  std::int64_t index = 0;
  Isometry T_world_body = Isometry::Identity();
  std::vector<simulation::PersonPose> people;
};

}  // namespace cairn
