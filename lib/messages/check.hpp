// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/clearance_t.hpp>
#include <cairn/clock_t.hpp>
#include <cairn/drive_command_t.hpp>
#include <cairn/goal_t.hpp>
#include <cairn/odometry_t.hpp>
#include <cairn/pose_t.hpp>
#include <cairn/range_t.hpp>
#include <cairn/stereo_frame_t.hpp>
#include <cairn/stop_t.hpp>
#include <cairn/wheel_state_t.hpp>

#include "core/result.hpp"

namespace cairn::messages {

/// Whether a message that decoded also makes sense, before a handler sees it: numbers finite, codes
/// known, sizes and counts possible. The error names the channel and the field.
[[nodiscard]] Result<void> check(const odometry_t& message);
[[nodiscard]] Result<void> check(const pose_t& message);
/// The stated sizes only; the images themselves are looked at by to_images.
[[nodiscard]] Result<void> check(const stereo_frame_t& message);
[[nodiscard]] Result<void> check(const wheel_state_t& message);
[[nodiscard]] Result<void> check(const drive_command_t& message);
[[nodiscard]] Result<void> check(const goal_t& message);
[[nodiscard]] Result<void> check(const range_t& message);
[[nodiscard]] Result<void> check(const clearance_t& message);
[[nodiscard]] Result<void> check(const clock_t& message);
[[nodiscard]] Result<void> check(const stop_t& message);

}  // namespace cairn::messages
