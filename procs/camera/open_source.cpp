// SPDX-License-Identifier: Apache-2.0
#include "procs/camera/open_source.hpp"

#include "camera/v4l2_device.hpp"
#include "camera/v4l2_pair.hpp"
#include "procs/camera/camera_node.hpp"

namespace cairn {
namespace {

Result<camera::RigCalibration> rig_of(const CameraConfig& config) {
  if (config.rig.empty())
    return fail("camera.rig: names no calibration file; source " + config.source + " needs one");
  return camera::load_rig(config.rig);
}

Result<std::unique_ptr<camera::FrameSource>> open_dataset_source(const CameraConfig& config) {
  if (config.dataset.empty())
    return fail("camera.dataset: names no folder; source dataset needs one");
  auto dataset = camera::open_dataset(config.dataset);
  if (!dataset) return tl::make_unexpected(dataset.error());
  return std::move(dataset->frames);
}

Result<std::unique_ptr<camera::FrameSource>> open_video_source(const CameraConfig& config) {
  const auto rig = rig_of(config);
  if (!rig) return tl::make_unexpected(rig.error());
  return camera::open_video_pair(config.video_left, config.video_right, *rig);
}

// The offset from the monotonic clock to data time is 0: it is fixed at boot and never stepped.
Result<std::unique_ptr<camera::FrameSource>> open_v4l2_source(const CameraConfig& config,
                                                              const bus::Node& node) {
  const auto rig = rig_of(config);
  if (!rig) return tl::make_unexpected(rig.error());
  auto pair = camera::V4l2Pair::create(
      config.v4l2, *rig, camera::linux_v4l2_device(), camera::linux_v4l2_device(),
      [&node] { return node.host_time(); }, 0);
  if (!pair) return tl::make_unexpected(pair.error());
  return std::unique_ptr<camera::FrameSource>(std::move(*pair));
}

}  // namespace

Result<std::unique_ptr<camera::FrameSource>> open_source(const CameraConfig& config,
                                                         const bus::Node& node) {
  if (config.source == "dataset") return open_dataset_source(config);
  if (config.source == "video") return open_video_source(config);
  return open_v4l2_source(config, node);
}

}  // namespace cairn
