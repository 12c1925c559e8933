// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "camera/mount.hpp"
#include "camera/recording.hpp"
#include "core/config.hpp"

namespace cairn::camera {

/// A dataset.yaml, key for key. Files are relative to its folder.
struct DatasetConfig {
  struct RectifiedCamera {
    double fx_px = 0;
    double fy_px = 0;
    double cx_px = 0;
    double cy_px = 0;
    double baseline_m = 0;

    void visit(ConfigVisitor& v) {
      v.number("fx_px", fx_px, {1, 1e6}, "px", "focal length along a row");
      v.number("fy_px", fy_px, {1, 1e6}, "px", "focal length along a column");
      v.number("cx_px", cx_px, {-1e6, 1e6}, "px", "principal point");
      v.number("cy_px", cy_px, {-1e6, 1e6}, "px", "principal point");
      v.number("baseline_m", baseline_m, {0.001, 100}, "m", "right camera to the right by");
    }
  };
  struct Calibration {
    std::string format;
    std::string left;
    std::string right;

    void visit(ConfigVisitor& v) {
      v.choice("format", format, {"euroc"}, "form of the two files");
      v.text("left", left, "sensor file of the left camera");
      v.text("right", right, "sensor file of the right camera");
    }
  };
  struct Truth {
    std::string file;
    std::string format;
    std::string frame;

    void visit(ConfigVisitor& v) {
      v.text("file", file, "true poses");
      v.choice("format", format, {"kitti", "tum", "euroc"}, "form of that file");
      v.choice("frame", frame, {"left_camera", "body"}, "whose pose it gives");
    }
  };
  struct Map {
    double resolution_m = 0;
    double max_range_m = 0;

    void visit(ConfigVisitor& v) {
      v.number("resolution_m", resolution_m, {0.001, 10}, "m", "block size that suits the place");
      v.number("max_range_m", max_range_m, {0.1, 1000}, "m", "range that suits the place");
    }
  };

  std::string left;
  std::string right;
  std::string depth;
  double scale_m = 0;
  std::vector<double> invalid;
  double rate_hz = 0;
  std::string timestamps;
  std::string timestamps_us;
  bool rectified = false;
  RectifiedCamera camera;
  Calibration calibration;
  MountConfig mount;
  Truth truth;
  Map map;

  void visit(ConfigVisitor& v) {
    v.text("left", left, "left images, for example image_l/*.png; sorted by name");
    v.text("right", right, "right images");
    v.text("depth", depth, "depth images, instead of left and right: 16 bits, one channel");
    v.number("scale_m", scale_m, {1e-6, 1}, "m", "metres per unit of a depth image");
    v.numbers("invalid", invalid, 0, 16, {0, 65535}, "", "values of a depth image for no answer");
    v.number("rate_hz", rate_hz, {0.01, 1000}, "Hz", "frame i is taken at i / rate");
    v.choice("timestamps", timestamps, {"file_name_ns"}, "names of the left or depth images");
    v.text("timestamps_us", timestamps_us, "file with the time of every frame, one per line");
    v.flag("rectified", rectified, "images are row-aligned and free of distortion: needs camera");
    v.group("camera", camera, "a rectified rig, or the virtual rig of a depth recording");
    v.group("calibration", calibration, "a rig that is not rectified");
    v.group("mount", mount, "the left camera on the body; with camera");
    v.group("truth", truth, "true poses, for evaluation alone");
    v.group("map", map, "what suits the place");
  }
};

/// What a dataset.yaml describes; errors name file, line and key, or the image that is missing.
[[nodiscard]] Result<Recording> find_described_recording(const std::filesystem::path& dataset_yaml);

}  // namespace cairn::camera
