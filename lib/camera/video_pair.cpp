// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

#include "camera/frame_source.hpp"

namespace cairn::camera {
namespace {

/// One video file, read forward; going back begins anew, because seeking by time is inexact in most
/// containers.
class Video {
 public:
  explicit Video(std::string file) : file_{std::move(file)} {}

  [[nodiscard]] Result<void> open() {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file_, error)) return fail(file_ + ": no such file");
    position_ = 0;
    try {
      if (!capture_.open(file_, cv::CAP_FFMPEG)) return fail(file_ + ": is not a video");
      size_ = {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
               static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))};
      count_ = static_cast<std::int64_t>(capture_.get(cv::CAP_PROP_FRAME_COUNT));
      rate_hz_ = capture_.get(cv::CAP_PROP_FPS);
    } catch (const std::exception& problem) {
      return fail(file_ + ": " + problem.what());
    }
    if (count_ <= 0) return fail(file_ + ": does not say how many frames it holds");
    if (!std::isfinite(rate_hz_) || rate_hz_ <= 0) return fail(file_ + ": does not say its rate");
    return {};
  }

  /// Frame `index`; errors name the file and the frame.
  [[nodiscard]] Result<cv::Mat> read(std::int64_t index) {
    if (index < position_) {
      if (auto opened = open(); !opened) return tl::make_unexpected(opened.error());
    }
    cv::Mat image;
    try {
      bool grabbed = true;
      for (; grabbed && position_ <= index; ++position_) grabbed = capture_.grab();
      if (!grabbed || !capture_.retrieve(image) || image.empty()) {
        return fail(file_ + ": frame " + std::to_string(index) + " cannot be read");
      }
      return grey(image);
    } catch (const std::exception& problem) {
      return fail(file_ + ": frame " + std::to_string(index) + ": " + problem.what());
    }
  }

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] cv::Size size() const { return size_; }
  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_; }

 private:
  static cv::Mat grey(const cv::Mat& image) {
    if (image.channels() == 1) return image.clone();
    cv::Mat grey;
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
    return grey;
  }

  std::string file_;
  cv::VideoCapture capture_;
  std::int64_t position_ = 0;
  cv::Size size_;
  std::int64_t count_ = 0;
  double rate_hz_ = 0;
};

class VideoPair : public FrameSource {
 public:
  VideoPair(Video left, Video right, RigCalibration rig)
      : left_{std::move(left)}, right_{std::move(right)}, rig_{std::move(rig)} {}

  [[nodiscard]] const RigCalibration& rig() const override { return rig_; }
  [[nodiscard]] double rate_hz() const override { return left_.rate_hz(); }
  [[nodiscard]] std::optional<std::int64_t> size() const override { return left_.count(); }
  void seek(std::int64_t index) override {
    position_ = std::clamp<std::int64_t>(index, 0, left_.count());
  }
  [[nodiscard]] bool finished() const override { return position_ >= left_.count(); }

  [[nodiscard]] Result<Frame> next() override {
    if (finished()) return fail("the videos are at their end");
    Frame frame;
    frame.index = position_++;
    frame.utime = std::llround(static_cast<double>(frame.index) * 1e6 / left_.rate_hz());
    const auto left = left_.read(frame.index);
    if (!left) return tl::make_unexpected(left.error());
    const auto right = right_.read(frame.index);
    if (!right) return tl::make_unexpected(right.error());
    frame.left = *left;
    frame.right = *right;
    return frame;
  }

 private:
  Video left_;
  Video right_;
  RigCalibration rig_;
  std::int64_t position_ = 0;
};

Result<void> check_alike(const Video& left, const Video& right, const RigCalibration& rig) {
  const cv::Size size(rig.width_px, rig.height_px);
  for (const Video* video : {&left, &right}) {
    if (video->size() == size) continue;
    return fail(video->file() + ": is " + std::to_string(video->size().width) + " x " +
                std::to_string(video->size().height) + " pixels, the rig's images are " +
                std::to_string(size.width) + " x " + std::to_string(size.height));
  }
  if (left.count() != right.count()) {
    return fail(left.file() + " has " + std::to_string(left.count()) + " frames, " + right.file() +
                " has " + std::to_string(right.count()));
  }
  if (std::abs(left.rate_hz() - right.rate_hz()) > 1e-6 * left.rate_hz()) {
    return fail(left.file() + " has " + std::to_string(left.rate_hz()) + " frames a second, " +
                right.file() + " has " + std::to_string(right.rate_hz()));
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_video_pair(const std::string& left,
                                                     const std::string& right,
                                                     const RigCalibration& rig) {
  if (const auto checked = check(rig); !checked) {
    return fail("the calibration: " + checked.error().message);
  }
  Video left_video(left);
  Video right_video(right);
  if (const auto opened = left_video.open(); !opened) return tl::make_unexpected(opened.error());
  if (const auto opened = right_video.open(); !opened) return tl::make_unexpected(opened.error());
  if (const auto alike = check_alike(left_video, right_video, rig); !alike) {
    return tl::make_unexpected(alike.error());
  }
  return std::make_unique<VideoPair>(std::move(left_video), std::move(right_video), rig);
}

}  // namespace cairn::camera
