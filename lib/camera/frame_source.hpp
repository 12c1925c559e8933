// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "core/time.hpp"

namespace cairn::camera {

/// One capture. A stereo source fills left and right; a depth source fills depth_m alone.
struct Frame {
  std::int64_t index = 0;  ///< position in the source, from 0
  Utime utime = 0;
  cv::Mat left;         ///< CV_8UC1, raw as the camera saw it
  cv::Mat right;        ///< CV_8UC1, same size
  cv::Mat depth_m;      ///< CV_32FC1, along the optical axis; 0 = no answer
  int exposure_us = 0;  ///< 0 = not known
};

/// Where frames come from: two V4L2 cameras, two videos, or a recorded dataset.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The rig that took the frames; for a depth source a virtual rectified rig.
  [[nodiscard]] virtual const RigCalibration& rig() const = 0;
  [[nodiscard]] virtual bool is_depth() const { return false; }

  /// Nominal frames per second.
  [[nodiscard]] virtual double rate_hz() const = 0;

  /// Frames in all; nothing for a live camera.
  [[nodiscard]] virtual std::optional<std::int64_t> size() const { return std::nullopt; }

  /// Goes on at frame `index` (from 0). Live cameras ignore it.
  virtual void seek(std::int64_t index) { (void)index; }

  /// True once a recorded source has given its last frame.
  [[nodiscard]] virtual bool finished() const = 0;

  /// The next frame. An error names the file or device and what is wrong with it; the source stays
  /// usable: a recorded one has moved past the bad frame, a live one tries its device again.
  [[nodiscard]] virtual Result<Frame> next() = 0;
};

/// What a recording says about itself besides its frames; all optional.
struct DatasetInfo {
  std::string truth_file;       ///< absolute or relative to the working folder; empty: none
  std::string truth_format;     ///< kitti, tum or euroc
  std::string truth_frame;      ///< "left_camera" or "body": whose pose the truth gives
  double map_resolution_m = 0;  ///< 0 = nothing said
  double map_max_range_m = 0;   ///< 0 = nothing said
  std::vector<Utime> utimes;    ///< of all frames
};

struct Dataset {
  std::unique_ptr<FrameSource> frames;
  DatasetInfo info;
};

/// Opens a folder with a dataset.yaml, a EuRoC folder (mav0), or a KITTI odometry sequence folder
/// (image_0, image_1, calib.txt). Every frame's files are found and counted here, so that a missing
/// or surplus image is an error that names it before the first frame is published. A frame of
/// another size is refused by next().
[[nodiscard]] Result<Dataset> open_dataset(const std::string& folder);

/// Two video files of equal length and size; frame i at i / rate.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_video_pair(const std::string& left,
                                                                   const std::string& right,
                                                                   const RigCalibration& rig);

}  // namespace cairn::camera
