// SPDX-License-Identifier: Apache-2.0
#include "camera/recording.hpp"

#include <algorithm>
#include <utility>

#include "camera/image_decoding.hpp"

namespace cairn::camera {
namespace {

std::string text_of(cv::Size size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

class RecordedFrames : public FrameSource {
 public:
  explicit RecordedFrames(Recording recording) : recording_{std::move(recording)} {}

  [[nodiscard]] const RigCalibration& rig() const override { return recording_.rig; }
  [[nodiscard]] bool is_depth() const override { return !recording_.depth.empty(); }
  [[nodiscard]] double rate_hz() const override { return recording_.rate_hz; }
  [[nodiscard]] std::optional<std::int64_t> size() const override { return count(); }
  void seek(std::int64_t index) override {
    position_ = std::clamp<std::int64_t>(index, 0, count());
  }
  [[nodiscard]] bool finished() const override { return position_ >= count(); }

  [[nodiscard]] Result<Frame> next() override {
    if (finished()) return fail("the recording is at its end");
    const auto i = static_cast<std::size_t>(position_);
    Frame frame;
    frame.index = position_++;
    frame.utime = recording_.utimes[i];
    const auto filled = is_depth() ? fill_depth(i, frame) : fill_pair(i, frame);
    if (!filled) return tl::make_unexpected(filled.error());
    return frame;
  }

 private:
  [[nodiscard]] std::int64_t count() const {
    return static_cast<std::int64_t>(recording_.utimes.size());
  }

  [[nodiscard]] Result<void> fill_pair(std::size_t i, Frame& frame) const {
    auto left = of_the_rigs_size(recording_.left[i], read_grey_image(recording_.left[i]));
    if (!left) return tl::make_unexpected(left.error());
    auto right = of_the_rigs_size(recording_.right[i], read_grey_image(recording_.right[i]));
    if (!right) return tl::make_unexpected(right.error());
    frame.left = *left;
    frame.right = *right;
    return {};
  }

  [[nodiscard]] Result<void> fill_depth(std::size_t i, Frame& frame) const {
    auto depth_m = of_the_rigs_size(
        recording_.depth[i],
        read_depth_image(recording_.depth[i], recording_.depth_scale_m, recording_.invalid_depth));
    if (!depth_m) return tl::make_unexpected(depth_m.error());
    frame.depth_m = *depth_m;
    return {};
  }

  [[nodiscard]] Result<cv::Mat> of_the_rigs_size(const std::filesystem::path& file,
                                                 Result<cv::Mat> image) const {
    const cv::Size size(recording_.rig.width_px, recording_.rig.height_px);
    if (!image || image->size() == size) return image;
    return fail(file.string() + ": is " + text_of(image->size()) +
                " pixels, the rig's images are " + text_of(size));
  }

  Recording recording_;
  std::int64_t position_ = 0;
};

/// Of the first image that can be read; the error of the first if none can.
Result<cv::Size> image_size(const Recording& recording) {
  const bool depth = !recording.depth.empty();
  const FileList& files = depth ? recording.depth : recording.left;
  Result<cv::Mat> first = fail("a recording without images");
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto image = depth ? read_depth_image(files[i], 1, {}) : read_grey_image(files[i]);
    if (image) return image->size();
    if (i == 0) first = image;
  }
  return tl::make_unexpected(first.error());
}

}  // namespace

Result<Dataset> open_recording(Recording recording) {
  const std::size_t count =
      recording.depth.empty() ? recording.left.size() : recording.depth.size();
  if (recording.utimes.size() != count) {
    return fail(std::to_string(recording.utimes.size()) + " times for " + std::to_string(count) +
                " frames");
  }
  if (recording.rig.width_px == 0) {
    const auto size = image_size(recording);
    if (!size) return tl::make_unexpected(size.error());
    recording.rig.width_px = size->width;
    recording.rig.height_px = size->height;
  }
  recording.rig.id = calibration_id(recording.rig);
  if (const auto checked = check(recording.rig); !checked) {
    return fail("the calibration: " + checked.error().message);
  }
  Dataset dataset;
  dataset.info = recording.info;
  dataset.info.utimes = recording.utimes;
  dataset.frames = std::make_unique<RecordedFrames>(std::move(recording));
  return dataset;
}

}  // namespace cairn::camera
