// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/rig_calibration_t.hpp>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "core/time.hpp"

namespace cairn::messages {

/// The rig as every receiver will have it: poses as_sent, `id` the hash of that. Whoever sends
/// CALIBRATION computes with this rig and stamps its frames with this id. Doing it twice changes
/// nothing.
[[nodiscard]] camera::RigCalibration as_sent(const camera::RigCalibration& rig);

/// The message for as_sent(rig).
[[nodiscard]] rig_calibration_t to_message(const camera::RigCalibration& rig, Utime utime);

/// Refuses what camera::check refuses, an unknown distortion model, poses that to_isometry refuses,
/// and an id that is not the hash of the content.
[[nodiscard]] Result<camera::RigCalibration> to_rig(const rig_calibration_t& message);

}  // namespace cairn::messages
