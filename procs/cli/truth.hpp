// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/geometry.hpp"
#include "evaluation/trajectory.hpp"

namespace cairn::cli {

/// The format of a trajectory file by its first line of numbers: "kitti" (12 numbers), "tum" (8) or
/// "euroc" (commas).
[[nodiscard]] Result<std::string> guess_format(const std::filesystem::path& file);

/// The true poses of the body, in the frame of the first one. `format` empty: guessed. `frame` is
/// left_camera or body; empty: left_camera for KITTI, else body. Only KITTI uses the frame times.
[[nodiscard]] Result<evaluation::Trajectory> read_body_truth(const std::filesystem::path& file,
                                                             std::string format, std::string frame,
                                                             std::span<const Utime> frame_times,
                                                             const Isometry& T_body_left);

}  // namespace cairn::cli
