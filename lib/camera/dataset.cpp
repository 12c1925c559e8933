// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "camera/dataset_yaml.hpp"
#include "camera/euroc_folder.hpp"
#include "camera/frame_source.hpp"
#include "camera/kitti_folder.hpp"

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;

bool there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

Result<Recording> find_recording(const fs::path& folder) {
  if (there(folder / "dataset.yaml")) return find_described_recording(folder / "dataset.yaml");
  if (there(folder / "mav0")) return find_euroc_recording(folder / "mav0");
  if (there(folder / "cam0" / "data")) return find_euroc_recording(folder);
  if (there(folder / "image_0")) return find_kitti_recording(folder);
  return fail(folder.string() +
              ": is no dataset: it has no dataset.yaml, no mav0 (EuRoC) and no image_0 (KITTI)");
}

}  // namespace

Result<Dataset> open_dataset(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return fail(folder + ": no such folder");
  auto recording = find_recording(folder);
  if (!recording) return tl::make_unexpected(recording.error());
  auto dataset = open_recording(std::move(*recording));
  if (!dataset) return fail(folder + ": " + dataset.error().message);
  return dataset;
}

}  // namespace cairn::camera
