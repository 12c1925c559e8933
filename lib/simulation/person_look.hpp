// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "simulation/person_pose.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// What somebody looks like: two legs that swing, a body and a head, upright on z = 0, within the
/// person's circle. Box::material counts person_materials().
[[nodiscard]] std::vector<Box> person_boxes(const Person& person, const PersonPose& pose);

/// Of several, one after the other; a pose of somebody who is not among the people is left out.
[[nodiscard]] std::vector<Box> people_boxes(std::span<const Person> people,
                                            std::span<const PersonPose> poses);

/// Trousers, jersey, and face and hair; others for everybody.
[[nodiscard]] std::vector<Material> person_materials(std::size_t person);

}  // namespace cairn::simulation
