// SPDX-License-Identifier: Apache-2.0
#include "messages/calibration_messages.hpp"

#include <optional>
#include <string>

#include "messages/geometry_messages.hpp"

namespace cairn::messages {
namespace {

constexpr int kMaxCoefficients = 8;

std::int8_t distortion_code(camera::Distortion distortion) {
  switch (distortion) {
    case camera::Distortion::kNone:
      return camera_model_t::DISTORTION_NONE;
    case camera::Distortion::kRadialTangential:
      return camera_model_t::DISTORTION_RADIAL_TANGENTIAL;
    case camera::Distortion::kEquidistant:
      return camera_model_t::DISTORTION_EQUIDISTANT;
  }
  return -1;
}

std::optional<camera::Distortion> distortion_of(std::int8_t code) {
  switch (code) {
    case camera_model_t::DISTORTION_NONE:
      return camera::Distortion::kNone;
    case camera_model_t::DISTORTION_RADIAL_TANGENTIAL:
      return camera::Distortion::kRadialTangential;
    case camera_model_t::DISTORTION_EQUIDISTANT:
      return camera::Distortion::kEquidistant;
    default:
      return std::nullopt;
  }
}

camera_model_t camera_message(const camera::CameraModel& camera) {
  camera_model_t message{};
  message.fx_px = camera.fx_px;
  message.fy_px = camera.fy_px;
  message.cx_px = camera.cx_px;
  message.cy_px = camera.cy_px;
  message.distortion = distortion_code(camera.distortion);
  message.coefficient_count = static_cast<std::int32_t>(camera.coefficients.size());
  message.coefficients = camera.coefficients;
  return message;
}

Result<camera::CameraModel> to_camera(const camera_model_t& message, const std::string& field) {
  const auto distortion = distortion_of(message.distortion);
  if (!distortion) {
    return fail("CALIBRATION " + field + ".distortion: " + std::to_string(message.distortion) +
                " is no known model");
  }
  if (!message.counts_agree() || message.coefficient_count > kMaxCoefficients) {
    return fail("CALIBRATION " + field + ".coefficient_count: " +
                std::to_string(message.coefficient_count) + " does not fit");
  }
  camera::CameraModel camera;
  camera.fx_px = message.fx_px;
  camera.fy_px = message.fy_px;
  camera.cx_px = message.cx_px;
  camera.cy_px = message.cy_px;
  camera.distortion = *distortion;
  camera.coefficients = message.coefficients;
  return camera;
}

}  // namespace

camera::RigCalibration as_sent(const camera::RigCalibration& rig) {
  camera::RigCalibration sent = rig;
  sent.T_right_left = as_sent(rig.T_right_left);
  sent.T_body_left = as_sent(rig.T_body_left);
  sent.id = camera::calibration_id(sent);
  return sent;
}

rig_calibration_t to_message(const camera::RigCalibration& rig, Utime utime) {
  const camera::RigCalibration sent = as_sent(rig);
  rig_calibration_t message{};
  message.header.utime = utime;
  message.calibration_id = static_cast<std::int64_t>(sent.id);
  message.width_px = sent.width_px;
  message.height_px = sent.height_px;
  message.left = camera_message(sent.left);
  message.right = camera_message(sent.right);
  message.T_right_left = to_message(sent.T_right_left);
  message.T_body_left = to_message(sent.T_body_left);
  message.rectified = sent.rectified ? 1 : 0;
  return message;
}

Result<camera::RigCalibration> to_rig(const rig_calibration_t& message) {
  auto left = to_camera(message.left, "left");
  if (!left) return fail(left.error().message);
  auto right = to_camera(message.right, "right");
  if (!right) return fail(right.error().message);
  const auto T_right_left = to_isometry(message.T_right_left, "CALIBRATION T_right_left");
  if (!T_right_left) return fail(T_right_left.error().message);
  const auto T_body_left = to_isometry(message.T_body_left, "CALIBRATION T_body_left");
  if (!T_body_left) return fail(T_body_left.error().message);

  camera::RigCalibration rig;
  rig.id = static_cast<std::uint64_t>(message.calibration_id);
  rig.width_px = message.width_px;
  rig.height_px = message.height_px;
  rig.left = std::move(*left);
  rig.right = std::move(*right);
  rig.T_right_left = *T_right_left;
  rig.T_body_left = *T_body_left;
  rig.rectified = message.rectified != 0;
  if (const auto sound = camera::check(rig); !sound) {
    return fail("CALIBRATION: " + sound.error().message);
  }
  if (rig.id != camera::calibration_id(rig)) {
    return fail("CALIBRATION calibration_id: is not the hash of the content");
  }
  return rig;
}

}  // namespace cairn::messages
