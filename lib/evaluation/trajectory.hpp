// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/time.hpp"

namespace cairn::evaluation {

/// Where something was, at one moment of data time, in the frame that its trajectory belongs to.
struct StampedPose {
  Utime utime = 0;
  Isometry T = Isometry::Identity();
};

/// Poses in order of time: utime rises strictly.
using Trajectory = std::vector<StampedPose>;

/// All readers refuse, with "file:line: why": a wrong number of fields, what is no finite number,
/// positions over 1e9 m, rotations off by more than 2 %, times that do not rise, and a file without
/// a pose. Lines that begin with # and blank lines are skipped; rotations come back exactly
/// orthonormal.

/// TUM: `t x y z qx qy qz qw`, t in seconds (rounded to the microsecond), x y z in metres.
[[nodiscard]] Result<Trajectory> read_tum(const std::filesystem::path& file);

/// KITTI: the upper 3x4 of a pose row by row, metres. Line i gets times[i]; lines beyond the times
/// are refused, times beyond the lines are not used.
[[nodiscard]] Result<Trajectory> read_kitti(const std::filesystem::path& file,
                                            std::span<const Utime> times);

/// EuRoC: `t,x,y,z,qw,qx,qy,qz[,...]`, t in nanoseconds (rounded to the microsecond), metres.
[[nodiscard]] Result<Trajectory> read_euroc(const std::filesystem::path& file);

/// One of the above by its name in a dataset.yaml: "tum", "kitti" or "euroc". Only kitti uses the
/// frame times.
[[nodiscard]] Result<Trajectory> read_trajectory(const std::filesystem::path& file,
                                                 std::string_view format,
                                                 std::span<const Utime> frame_times);

/// TUM text, t = utime / 1e6 with six decimals; what is read back differs by less than 1e-9 (m,
/// rad). The same poses give the same bytes.
[[nodiscard]] std::string tum_text(std::span<const StampedPose> poses);
[[nodiscard]] Result<void> write_tum(const std::filesystem::path& file,
                                     std::span<const StampedPose> poses);

/// Body poses from left-camera poses T_w_c in a world of the camera's own, in the frame of the
/// first body pose: T_b0_bi = T_body_left * inv(T_w_c0) * T_w_ci * inv(T_body_left). The first is
/// the identity.
[[nodiscard]] Trajectory body_from_left_camera(std::span<const StampedPose> T_world_left,
                                               const Isometry& T_body_left);

/// Length of the way through all positions [m].
[[nodiscard]] double path_length_m(std::span<const StampedPose> poses);

}  // namespace cairn::evaluation
