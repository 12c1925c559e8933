// SPDX-License-Identifier: Apache-2.0
#include "camera/kitti_folder.hpp"

#include <array>
#include <cmath>
#include <map>

#include "camera/mount.hpp"
#include "camera/text_lines.hpp"
#include "camera/timestamps.hpp"

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultRate_hz = 10;
constexpr double kCameraHeight_m = 1.65;

/// A projection matrix of a rectified camera, row by row.
using Projection = std::array<double, 12>;

Result<Projection> parse_projection(const std::string& text) {
  const auto numbers = parse_numbers(text);
  if (!numbers) return tl::make_unexpected(numbers.error());
  if (numbers->size() != 12) {
    return fail("has " + std::to_string(numbers->size()) + " numbers instead of 12");
  }
  Projection P{};
  std::copy(numbers->begin(), numbers->end(), P.begin());
  return P;
}

/// By label; rows without labels are P0, P1 and so on.
Result<std::map<std::string, Projection>> read_projections(const fs::path& file) {
  const auto lines = read_lines(file);
  if (!lines) return tl::make_unexpected(lines.error());
  std::map<std::string, Projection> projections;
  for (const TextLine& line : *lines) {
    const std::size_t colon = line.text.find(':');
    const bool labelled = colon != std::string::npos;
    const std::string label =
        labelled ? line.text.substr(0, colon) : "P" + std::to_string(projections.size());
    if (label != "P0" && label != "P1") continue;
    const auto P = parse_projection(labelled ? line.text.substr(colon + 1) : line.text);
    if (!P) return fail(place(file, line) + label + ": " + P.error().message);
    if (!projections.emplace(label, *P).second) {
      return fail(place(file, line) + label + ": stands here twice");
    }
  }
  for (const char* label : {"P0", "P1"}) {
    if (!projections.contains(label)) return fail(file.string() + ": " + label + ": is missing");
  }
  return projections;
}

Result<RigCalibration> load_kitti_rig(const fs::path& file) {
  const auto projections = read_projections(file);
  if (!projections) return tl::make_unexpected(projections.error());
  const Projection& P0 = projections->at("P0");
  const Projection& P1 = projections->at("P1");
  const double fx_px = P0[0];
  if (!(fx_px > 0)) return fail(file.string() + ": P0: its focal length is not positive");
  for (const std::size_t i : {0U, 1U, 2U, 4U, 5U, 6U, 8U, 9U, 10U}) {
    if (std::abs(P1[i] - P0[i]) > 1e-6 * fx_px) {
      return fail(file.string() + ": P1: differs from P0 by more than the baseline");
    }
  }
  MountConfig mount;
  mount.xyz_m = {0, 0, kCameraHeight_m};
  RigCalibration rig =
      rectified_rig(fx_px, P0[5], P0[2], P0[6], (P0[3] - P1[3]) / fx_px, 1, 1, mounted(mount));
  if (const auto checked = check(rig); !checked) {
    return fail(file.string() + ": " + checked.error().message);
  }
  rig.width_px = 0;
  rig.height_px = 0;
  return rig;
}

std::string truth_file(const fs::path& folder) {
  const fs::path name =
      folder.filename().empty() ? folder.parent_path().filename() : folder.filename();
  std::error_code error;
  for (const fs::path& file :
       {folder / "poses.txt", folder / ".." / ".." / "poses" / (name.string() + ".txt")}) {
    if (fs::is_regular_file(file, error)) return file.string();
  }
  return "";
}

/// Times of the frames: from times.txt, or at the benchmark's rate.
Result<std::vector<Utime>> times(const fs::path& folder, const FileList& files) {
  const fs::path file = folder / "times.txt";
  std::error_code error;
  if (!fs::exists(file, error)) {
    if (const auto whole = check_no_gap(files); !whole) return tl::make_unexpected(whole.error());
    return times_at_rate(files.size(), kDefaultRate_hz);
  }
  auto utimes = read_times_s(file);
  if (utimes && utimes->size() != files.size()) {
    return fail(file.string() + ": " + std::to_string(utimes->size()) + " times for " +
                std::to_string(files.size()) + " images");
  }
  return utimes;
}

}  // namespace

Result<Recording> find_kitti_recording(const fs::path& folder) {
  auto left = list_files(folder, "image_0/*.png");
  if (!left) return tl::make_unexpected(left.error());
  auto right = list_files(folder, "image_1/*.png");
  if (!right) return tl::make_unexpected(right.error());
  if (const auto paired = check_pairs(*left, *right, false); !paired) {
    return tl::make_unexpected(paired.error());
  }
  auto utimes = times(folder, *left);
  if (!utimes) return tl::make_unexpected(utimes.error());
  auto rig = load_kitti_rig(folder / "calib.txt");
  if (!rig) return tl::make_unexpected(rig.error());

  Recording recording;
  recording.left = std::move(*left);
  recording.right = std::move(*right);
  recording.utimes = std::move(*utimes);
  recording.rate_hz = nominal_rate_hz(recording.utimes);
  recording.rig = std::move(*rig);
  recording.info.truth_file = truth_file(folder);
  if (!recording.info.truth_file.empty()) {
    recording.info.truth_format = "kitti";
    recording.info.truth_frame = "left_camera";
  }
  recording.info.map_resolution_m = 0.2;
  recording.info.map_max_range_m = 30;
  return recording;
}

}  // namespace cairn::camera
