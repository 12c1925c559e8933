// SPDX-License-Identifier: Apache-2.0
#include "messages/disparity_messages.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "messages/disparity_packing.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn::messages {
namespace {

constexpr int kMaxSide_px = 16384;

rectified_camera_t camera_message(const stereo::RectifiedCamera& camera) {
  rectified_camera_t message{};
  message.f_px = camera.f_px;
  message.cx_px = camera.cx_px;
  message.cy_px = camera.cy_px;
  message.doffs_px = camera.doffs_px;
  message.baseline_m = camera.baseline_m;
  message.width_px = camera.width_px;
  message.height_px = camera.height_px;
  message.T_body_camera = to_message(camera.T_body_camera);
  return message;
}

Result<stereo::RectifiedCamera> to_camera(const rectified_camera_t& message) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(message.f_px)) return fail("DISPARITY camera.f_px: is not a positive number");
  if (!positive(message.baseline_m)) {
    return fail("DISPARITY camera.baseline_m: is not a positive number");
  }
  for (const double value : {message.cx_px, message.cy_px, message.doffs_px}) {
    if (!std::isfinite(value)) return fail("DISPARITY camera: cx, cy or doffs is not finite");
  }
  for (const int side_px : {message.width_px, message.height_px}) {
    if (side_px < 1 || side_px > kMaxSide_px) {
      return fail("DISPARITY camera: " + std::to_string(message.width_px) + " x " +
                  std::to_string(message.height_px) + " px is not the size of an image");
    }
  }
  const auto T_body_camera = to_isometry(message.T_body_camera, "DISPARITY camera.T_body_camera");
  if (!T_body_camera) return fail(T_body_camera.error().message);
  return stereo::RectifiedCamera{message.f_px,      message.cx_px,      message.cy_px,
                                 message.doffs_px,  message.baseline_m, message.width_px,
                                 message.height_px, *T_body_camera};
}

/// Whether every point of the grid is a pixel of the image.
Result<void> check_grid(const disparity_t& message) {
  if (message.step_px < 1 || message.step_px > kMaxSide_px) {
    return fail("DISPARITY step_px: " + std::to_string(message.step_px) + " is out of range");
  }
  if (message.first_row < 0 || message.first_row > kMaxGridSide || message.rows < 1 ||
      message.rows > kMaxGridSide || message.columns < 1 || message.columns > kMaxGridSide) {
    return fail("DISPARITY rows, columns: " + std::to_string(message.rows) + " from row " +
                std::to_string(message.first_row) + " on, " + std::to_string(message.columns) +
                ": out of range");
  }
  const std::int64_t last_x_px = std::int64_t{message.columns - 1} * message.step_px;
  const std::int64_t last_y_px =
      std::int64_t{message.first_row + message.rows - 1} * message.step_px;
  if (last_x_px >= message.camera.width_px || last_y_px >= message.camera.height_px) {
    return fail("DISPARITY rows, columns: the grid reaches beyond its camera's image");
  }
  return {};
}

}  // namespace

Result<disparity_t> to_message(const stereo::DisparityImage& image, std::uint64_t calibration_id) {
  return to_band_message(image, calibration_id, 0, image.rows());
}

Result<disparity_t> to_band_message(const stereo::DisparityImage& image,
                                    std::uint64_t calibration_id, int first_row, int row_count) {
  if (first_row < 0 || row_count < 1 || first_row > image.rows() - row_count ||
      image.code.size() != image.disparity_16ths.size()) {
    return fail("DISPARITY: rows " + std::to_string(first_row) + " to " +
                std::to_string(std::int64_t{first_row} + row_count) + " of " +
                std::to_string(image.rows()) + ": there are none");
  }
  const cv::Range rows(first_row, first_row + row_count);
  auto packed = pack({image.disparity_16ths.rowRange(rows), image.code.rowRange(rows)});
  if (!packed) return fail("DISPARITY: " + packed.error().message);

  disparity_t message{};
  message.header.utime = image.utime;
  message.calibration_id = static_cast<std::int64_t>(calibration_id);
  message.columns = image.cols();
  message.rows = row_count;
  message.first_row = first_row;
  message.step_px = image.step_px;
  message.camera = camera_message(image.camera);
  message.packed_size = static_cast<std::int32_t>(packed->size());
  message.packed = std::move(*packed);
  if (const auto sound = check_grid(message); !sound) return fail(sound.error().message);
  if (message.getEncodedSize() > kMaxDisparityMessage_bytes) {
    return fail("DISPARITY: " + std::to_string(message.columns) + "x" + std::to_string(row_count) +
                " points need " + std::to_string(message.getEncodedSize()) +
                " bytes, the limit is " + std::to_string(kMaxDisparityMessage_bytes) +
                "; send a coarser grid or fewer rows");
  }
  return message;
}

Result<stereo::DisparityImage> to_disparity(const disparity_t& message) {
  auto camera = to_camera(message.camera);
  if (!camera) return fail(camera.error().message);
  if (const auto sound = check_grid(message); !sound) return fail(sound.error().message);
  auto grid = unpack(message.packed, message.rows, message.columns);
  if (!grid) return fail("DISPARITY packed: " + grid.error().message);

  stereo::DisparityImage image;
  image.utime = message.header.utime;
  image.step_px = message.step_px;
  image.camera = *camera;
  const int first_y_px = message.first_row * message.step_px;
  const int end_y_px = (message.first_row + message.rows) * message.step_px;
  image.camera.cy_px -= first_y_px;
  image.camera.height_px = std::min(end_y_px, image.camera.height_px) - first_y_px;
  image.disparity_16ths = std::move(grid->disparity_16ths);
  image.code = std::move(grid->code);
  return image;
}

}  // namespace cairn::messages
