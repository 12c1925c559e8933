// SPDX-License-Identifier: Apache-2.0
#include "camera/dataset_yaml.hpp"

#include "camera/euroc_folder.hpp"
#include "camera/timestamps.hpp"

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;

bool given(const DatasetConfig::RectifiedCamera& camera) {
  return camera.fx_px != 0 || camera.fy_px != 0 || camera.cx_px != 0 || camera.cy_px != 0 ||
         camera.baseline_m != 0;
}
bool given(const DatasetConfig::Calibration& calibration) {
  return !calibration.format.empty() || !calibration.left.empty() || !calibration.right.empty();
}
bool given(const DatasetConfig::Truth& truth) {
  return !truth.file.empty() || !truth.format.empty() || !truth.frame.empty();
}

/// Which keys must, and must not, stand together.
Result<void> check_keys(const DatasetConfig& config) {
  const bool depth = !config.depth.empty();
  if (depth && !(config.left.empty() && config.right.empty())) {
    return fail("depth: cannot stand beside left and right");
  }
  if (!depth && config.left.empty()) return fail("left: is missing (or depth)");
  if (!depth && config.right.empty()) return fail("right: is missing");
  if (depth && config.scale_m == 0) return fail("scale_m: is missing");
  if (!depth && (config.scale_m != 0 || !config.invalid.empty())) {
    return fail("scale_m, invalid: belong to a depth recording");
  }
  const int clocks = (config.rate_hz != 0 ? 1 : 0) + (config.timestamps.empty() ? 0 : 1) +
                     (config.timestamps_us.empty() ? 0 : 1);
  if (clocks != 1) return fail("one of rate_hz, timestamps and timestamps_us must be given");

  const bool rectified = depth || config.rectified;
  if (rectified && given(config.calibration)) {
    return fail("calibration: belongs to images that are not rectified");
  }
  if (!rectified && given(config.camera)) {
    return fail("camera: belongs to rectified images; rectified is false");
  }
  if (rectified &&
      (config.camera.fx_px == 0 || config.camera.fy_px == 0 || config.camera.baseline_m == 0)) {
    return fail("camera: fx_px, fy_px and baseline_m must be given");
  }
  const DatasetConfig::Calibration& files = config.calibration;
  if (!rectified && (files.format.empty() || files.left.empty() || files.right.empty())) {
    return fail("calibration: format, left and right must be given");
  }
  if (!rectified && !(config.mount.xyz_m.empty() && config.mount.rpy_deg.empty())) {
    return fail("mount: is said by the calibration files (T_BS)");
  }
  if (given(config.truth) &&
      (config.truth.file.empty() || config.truth.format.empty() || config.truth.frame.empty())) {
    return fail("truth: file, format and frame must be given");
  }
  return {};
}

Result<void> find_files(const DatasetConfig& config, const fs::path& folder, Recording& recording) {
  if (!config.depth.empty()) {
    auto depth = list_files(folder, config.depth);
    if (!depth) return tl::make_unexpected(depth.error());
    recording.depth = std::move(*depth);
    return {};
  }
  auto left = list_files(folder, config.left);
  if (!left) return tl::make_unexpected(left.error());
  auto right = list_files(folder, config.right);
  if (!right) return tl::make_unexpected(right.error());
  recording.left = std::move(*left);
  recording.right = std::move(*right);
  return check_pairs(recording.left, recording.right, !config.timestamps.empty());
}

Result<std::vector<Utime>> find_times(const DatasetConfig& config, const fs::path& folder,
                                      const FileList& files) {
  if (!config.timestamps.empty()) return times_of_names_ns(files);
  if (config.timestamps_us.empty()) {
    if (const auto whole = check_no_gap(files); !whole) return tl::make_unexpected(whole.error());
    return times_at_rate(files.size(), config.rate_hz);
  }
  const fs::path file = folder / config.timestamps_us;
  auto utimes = read_times_us(file);
  if (utimes && utimes->size() != files.size()) {
    return fail(file.string() + ": " + std::to_string(utimes->size()) + " times for " +
                std::to_string(files.size()) + " frames");
  }
  return utimes;
}

Result<RigCalibration> find_rig(const DatasetConfig& config, const fs::path& folder) {
  if (given(config.calibration)) {
    return load_euroc_rig(folder / config.calibration.left, folder / config.calibration.right);
  }
  const auto& camera = config.camera;
  return rectified_rig(camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, camera.baseline_m, 0,
                       0, mounted(config.mount));
}

DatasetInfo info(const DatasetConfig& config, const fs::path& folder) {
  DatasetInfo info;
  if (given(config.truth)) {
    info.truth_file = (folder / config.truth.file).string();
    info.truth_format = config.truth.format;
    info.truth_frame = config.truth.frame;
  }
  info.map_resolution_m = config.map.resolution_m;
  info.map_max_range_m = config.map.max_range_m;
  return info;
}

}  // namespace

Result<Recording> find_described_recording(const fs::path& dataset_yaml) {
  const auto config = load_yaml<DatasetConfig>(dataset_yaml);
  if (!config) return tl::make_unexpected(config.error());
  if (const auto checked = check_keys(*config); !checked) {
    return fail(dataset_yaml.string() + ": " + checked.error().message);
  }
  const fs::path folder = dataset_yaml.parent_path();
  Recording recording;
  if (const auto found = find_files(*config, folder, recording); !found) {
    return fail(dataset_yaml.string() + ": " + found.error().message);
  }
  const FileList& files = recording.depth.empty() ? recording.left : recording.depth;
  auto utimes = find_times(*config, folder, files);
  if (!utimes) return tl::make_unexpected(utimes.error());
  auto rig = find_rig(*config, folder);
  if (!rig) return tl::make_unexpected(rig.error());

  recording.depth_scale_m = config->scale_m;
  recording.invalid_depth.assign(config->invalid.begin(), config->invalid.end());
  recording.utimes = std::move(*utimes);
  recording.rate_hz = config->rate_hz != 0 ? config->rate_hz : nominal_rate_hz(recording.utimes);
  recording.rig = std::move(*rig);
  recording.info = info(*config, folder);
  return recording;
}

}  // namespace cairn::camera
