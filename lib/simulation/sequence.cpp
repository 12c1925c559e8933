// SPDX-License-Identifier: Apache-2.0
#include "simulation/sequence.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>

#include "core/atomic_file.hpp"

namespace cairn::simulation {
namespace {

namespace fs = std::filesystem;

std::string number(double value) {
  std::array<char, 64> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

std::string list(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + number(value);
  return "[" + text + "]";
}

/// Roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll), in degrees.
Eigen::Vector3d rpy_deg(const Eigen::Matrix3d& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  return 180 / std::numbers::pi *
         Eigen::Vector3d(std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0)));
}

std::string dataset_yaml(const camera::RigCalibration& rig, const SequenceConfig& config) {
  const Eigen::Vector3d xyz_m = rig.T_body_left.translation();
  const Eigen::Vector3d rpy =
      rpy_deg(rig.T_body_left.linear() * R_body_camera_forward().transpose());
  return "# rendered: seed " + std::to_string(config.seed) +
         "\nleft: left/*.png\nright: right/*.png\nrate_hz: " + number(config.rate_hz) +
         "\nrectified: true\ncamera: {fx_px: " + number(rig.left.fx_px) +
         ", fy_px: " + number(rig.left.fy_px) + ", cx_px: " + number(rig.left.cx_px) +
         ", cy_px: " + number(rig.left.cy_px) + ", baseline_m: " + number(rig.baseline_m()) +
         "}\nmount: {xyz_m: " + list({xyz_m.x(), xyz_m.y(), xyz_m.z()}) +
         ", rpy_deg: " + list({rpy.x(), rpy.y(), rpy.z()}) +
         "}\ntruth: {file: truth.txt, format: tum, frame: body}\nmap: {resolution_m: " +
         number(config.map_resolution_m) + ", max_range_m: " + number(config.map_max_range_m) +
         "}\n";
}

/// What a dataset.yaml of a rectified rig can say.
Result<void> check_rig(const camera::RigCalibration& rig) {
  const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); };
  const Eigen::Vector3d& t = rig.T_right_left.translation();
  if (!rig.rectified || rig.left.distortion != camera::Distortion::kNone ||
      rig.right.distortion != camera::Distortion::kNone || !same(rig.left.fx_px, rig.right.fx_px) ||
      !same(rig.left.fy_px, rig.right.fy_px) || !same(rig.left.cx_px, rig.right.cx_px) ||
      !same(rig.left.cy_px, rig.right.cy_px) || !rig.T_right_left.linear().isIdentity(1e-9) ||
      !(t.x() < 0) || std::abs(t.y()) > 1e-9 || std::abs(t.z()) > 1e-9) {
    return fail("sequence: the rig is not a rectified one with two equal cameras side by side");
  }
  return {};
}

std::string image_name(std::size_t frame) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "%06zu.png", frame);
  return name.data();
}

Result<void> write_image(const fs::path& file, const cv::Mat& image) {
  try {
    if (cv::imwrite(file.string(), image,
                    {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY,
                     cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY})) {
      return {};
    }
  } catch (const cv::Exception& problem) {
    return fail(file.string() + ": cannot write: " + problem.err);
  }
  return fail(file.string() + ": cannot write");
}

Result<void> prepare_folder(const fs::path& folder, std::size_t frames) {
  std::error_code error;
  for (const char* side : {"left", "right"}) {
    fs::create_directories(folder / side, error);
    if (error) return fail((folder / side).string() + ": cannot make: " + error.message());
    if (fs::exists(folder / side / image_name(frames), error)) {
      return fail((folder / side / image_name(frames)).string() +
                  ": belongs to a longer recording; choose an empty folder");
    }
  }
  fs::remove(folder / "dataset.yaml", error);
  if (error)
    return fail((folder / "dataset.yaml").string() + ": cannot remove: " + error.message());
  return {};
}

Result<void> write_text(const fs::path& file, const std::string& text) {
  return write_file_atomically(file,
                               {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace

Result<void> render_sequence(const World& world, const camera::RigCalibration& rig,
                             const evaluation::Trajectory& path, const SequenceConfig& config,
                             const fs::path& folder, const Progress& progress) {
  if (path.empty()) return fail("sequence: the path holds no pose");
  if (const auto ok = check_rig(rig); !ok) return ok;
  const auto renderer = Renderer::create(world, rig, config.sensor, config.seed);
  if (!renderer) return tl::make_unexpected(renderer.error());
  if (const auto ok = prepare_folder(folder, path.size()); !ok) return ok;
  evaluation::Trajectory truth;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const RenderedPair pair = renderer->render(path[i].T, static_cast<std::int64_t>(i));
    for (const auto& [side, image] :
         {std::pair{"left", pair.left}, std::pair{"right", pair.right}}) {
      if (const auto ok = write_image(folder / side / image_name(i), image); !ok) return ok;
    }
    truth.push_back({std::llround(static_cast<double>(i) * 1e6 / config.rate_hz), path[i].T});
    if (progress) progress(i + 1, path.size());
  }
  if (const auto ok = evaluation::write_tum(folder / "truth.txt", truth); !ok) return ok;
  return write_text(folder / "dataset.yaml", dataset_yaml(rig, config));
}

}  // namespace cairn::simulation
