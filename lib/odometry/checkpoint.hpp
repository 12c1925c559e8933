// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "core/result.hpp"
#include "core/time.hpp"
#include "odometry/motion.hpp"
#include "odometry/track_kinematics.hpp"

namespace cairn::odometry {

/// What odometry needs to go on after a restart.
struct Checkpoint {
  Utime utime = 0;
  std::uint32_t epoch = 0;
  Isometry T_odom_body = Isometry::Identity();
  Twist twist = Twist::Zero();
  /// The one that the tracks' place at `utime` rests on: ticks tell how far they went meanwhile.
  std::optional<TrackReading> tracks;
};

/// 177 bytes, little end first, with a magic word in front and a checksum behind.
[[nodiscard]] std::vector<std::uint8_t> to_bytes(const Checkpoint& checkpoint);

/// An error names what is wrong: size, magic, checksum, a number that is not finite, a rotation
/// that is none.
[[nodiscard]] Result<Checkpoint> checkpoint_from_bytes(std::span<const std::uint8_t> bytes);

}  // namespace cairn::odometry
