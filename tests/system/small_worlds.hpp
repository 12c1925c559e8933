// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace cairn::testing {

/// A closed room of 3.4 x 3.2 m, nothing in it; `boxes` are more lines of its list of boxes.
inline std::filesystem::path small_world(const std::filesystem::path& folder,
                                         const std::string& boxes = "") {
  const std::filesystem::path file = folder / "small.yaml";
  std::ofstream(file) << R"(start: {at_m: [-0.9, -0.8], heading_deg: 30}
materials:
  - {name: stone, noise_contrast: 0.1, fine_m: 0.0025}
  - {name: wood, seed: 2, brightness: 0.4, noise_contrast: 0.12, fine_m: 0.0025}
walls:
  - {from_m: [-1.7, -1.6], to_m: [1.7, -1.6], material: stone}
  - {from_m: [1.7, -1.6], to_m: [1.7, 1.6], material: stone}
  - {from_m: [1.7, 1.6], to_m: [-1.7, 1.6], material: stone}
  - {from_m: [-1.7, 1.6], to_m: [-1.7, -1.6], material: stone}
boxes:
  - {name: floor, centre_m: [0, 0, -0.1], size_m: [3.6, 3.4, 0.2], material: wood}
  - {name: ceiling, centre_m: [0, 0, 2.6], size_m: [3.6, 3.4, 0.2], material: stone}
)" << boxes;
  return file;
}

/// So that the robot has to drive all round it to see what is behind it.
inline constexpr const char* kChest =
    "  - {name: chest, centre_m: [0.5, 0.4, 0.3], size_m: [0.5, 0.4, 0.6], material: wood}\n";

/// So that there is little to see behind it.
inline constexpr const char* kCrate =
    "  - {name: crate, centre_m: [1.3, 0, 0.25], size_m: [0.6, 0.5, 0.5], material: wood}\n";

}  // namespace cairn::testing
