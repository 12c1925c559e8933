// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "camera/v4l2_device.hpp"
#include "core/time.hpp"

namespace cairn::camera::testing {

/// The host's monotonic clock as a test moves it: waiting in poll() is what makes time go by.
struct FakeClock {
  HostTime now = 5'000'000;
};

/// What the driver has next: an image ready at a time, or a refusal of VIDIOC_DQBUF.
struct Shot {
  HostTime at = 0;
  std::vector<std::uint8_t> bytes;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  int refusal = 0;
};

/// A camera on the cable: it outlives every opening of its device. Defaults are those of a common
/// UVC webcam.
struct FakeCamera {
  struct Control {
    int minimum = 0;
    int maximum = 0;
    int value = 0;
    int refusal = 0;
  };

  std::shared_ptr<FakeClock> clock;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_YUYV};
  std::map<std::uint32_t, Control> controls{
      {V4L2_CID_EXPOSURE_AUTO, {0, 3, 3}},
      {V4L2_CID_EXPOSURE_AUTO_PRIORITY, {0, 1, 1}},
      {V4L2_CID_EXPOSURE_ABSOLUTE, {3, 2047, 250}},
      {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1}},
      {V4L2_CID_WHITE_BALANCE_TEMPERATURE, {2800, 6500, 4000}},
      {V4L2_CID_GAIN, {0, 255, 0}}};
  std::map<unsigned long, int> refusals;  ///< errno by VIDIOC_ request
  std::uint32_t width_px = 8;
  std::uint32_t height_px = 4;
  std::uint32_t row_padding_bytes = 0;
  bool plugged_in = true;
  std::deque<Shot> shots;
  int opened = 0;
  int closed = 0;
  int mapped = 0;
  int unmapped = 0;

  /// A YUYV image, evenly grey at `level`, with wild colours.
  void shoot(HostTime at, std::uint8_t level) {
    std::vector<std::uint8_t> bytes;
    for (std::uint32_t y = 0; y < height_px; ++y) {
      for (std::uint32_t x = 0; x < width_px; ++x) {
        bytes.push_back(level);
        bytes.push_back(static_cast<std::uint8_t>(37 * (x + 5 * y)));
      }
      bytes.insert(bytes.end(), row_padding_bytes, 0xee);
    }
    shots.push_back({at, bytes});
  }
};

class FakeV4l2Device : public V4l2Device {
 public:
  explicit FakeV4l2Device(std::shared_ptr<FakeCamera> camera) : camera_{std::move(camera)} {}

  int open(const std::string&) override {
    if (!camera_->plugged_in) return -ENODEV;
    ++camera_->opened;
    open_ = true;
    return 0;
  }

  int ioctl(unsigned long request, void* argument) override {
    if (!open_) return -EBADF;
    const auto refusal = camera_->refusals.find(request);
    if (refusal != camera_->refusals.end()) return -refusal->second;
    switch (request) {
      case VIDIOC_QUERYCAP:
        return query_capabilities(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT:
        return enumerate(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_S_FMT:
        return set_format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_S_PARM:
        return 0;
      case VIDIOC_QUERYCTRL:
        return query_control(*static_cast<v4l2_queryctrl*>(argument));
      case VIDIOC_S_CTRL:
        return set_control(*static_cast<v4l2_control*>(argument));
      case VIDIOC_G_CTRL:
        return get_control(*static_cast<v4l2_control*>(argument));
      case VIDIOC_REQBUFS:
        buffers_.assign(static_cast<v4l2_requestbuffers*>(argument)->count,
                        std::vector<std::uint8_t>(4096));
        return 0;
      case VIDIOC_QUERYBUF:
        static_cast<v4l2_buffer*>(argument)->length = 4096;
        static_cast<v4l2_buffer*>(argument)->m.offset =
            4096 * static_cast<v4l2_buffer*>(argument)->index;
        return 0;
      case VIDIOC_QBUF:
        queued_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        return 0;
      default:
        return -ENOTTY;
    }
  }

  int mmap(std::size_t length, std::int64_t offset, std::span<std::uint8_t>& mapped) override {
    ++camera_->mapped;
    mapped = {buffers_.at(static_cast<std::size_t>(offset) / 4096).data(), length};
    return 0;
  }
  void munmap(std::span<std::uint8_t>) override { ++camera_->unmapped; }

  int poll(int timeout_ms) override {
    FakeClock& clock = *camera_->clock;
    const HostTime until = clock.now + std::int64_t{timeout_ms} * 1000;
    const bool comes =
        !camera_->shots.empty() && !queued_.empty() && camera_->shots.front().at <= until;
    clock.now = comes ? std::max(clock.now, camera_->shots.front().at) : until;
    return comes ? 1 : 0;
  }

  void close() override {
    if (open_) ++camera_->closed;
    open_ = false;
    queued_.clear();
  }

 private:
  static int query_capabilities(v4l2_capability& capability) {
    capability.capabilities = V4L2_CAP_DEVICE_CAPS;
    capability.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    return 0;
  }
  int enumerate(v4l2_fmtdesc& description) const {
    if (description.index >= camera_->formats.size()) return -EINVAL;
    description.pixelformat = camera_->formats[description.index];
    return 0;
  }
  /// As drivers do: the nearest that it has.
  int set_format(v4l2_format& format) const {
    format.fmt.pix.width = camera_->width_px;
    format.fmt.pix.height = camera_->height_px;
    format.fmt.pix.bytesperline =
        format.fmt.pix.pixelformat == V4L2_PIX_FMT_MJPEG
            ? 0
            : camera_->row_padding_bytes +
                  camera_->width_px * (format.fmt.pix.pixelformat == V4L2_PIX_FMT_GREY ? 1 : 2);
    return 0;
  }
  int query_control(v4l2_queryctrl& query) const {
    const auto control = camera_->controls.find(query.id);
    if (control == camera_->controls.end()) return -EINVAL;
    query.minimum = control->second.minimum;
    query.maximum = control->second.maximum;
    return 0;
  }
  int set_control(const v4l2_control& value) {
    FakeCamera::Control& control = camera_->controls.at(value.id);
    if (control.refusal != 0) return -control.refusal;
    control.value = value.value;
    return 0;
  }
  int get_control(v4l2_control& value) const {
    const auto control = camera_->controls.find(value.id);
    if (control == camera_->controls.end()) return -EINVAL;
    value.value = control->second.value;
    return 0;
  }
  int dequeue(v4l2_buffer& buffer) {
    if (camera_->shots.empty() || queued_.empty()) return -EAGAIN;
    const Shot shot = camera_->shots.front();
    camera_->shots.pop_front();
    if (shot.refusal != 0) return -shot.refusal;
    buffer.index = queued_.front();
    queued_.pop_front();
    buffer.bytesused = static_cast<std::uint32_t>(shot.bytes.size());
    buffer.flags = shot.flags;
    buffer.timestamp.tv_sec = shot.at / 1'000'000;
    buffer.timestamp.tv_usec = shot.at % 1'000'000;
    std::copy(shot.bytes.begin(), shot.bytes.end(), buffers_.at(buffer.index).begin());
    return 0;
  }

  std::shared_ptr<FakeCamera> camera_;
  bool open_ = false;
  std::vector<std::vector<std::uint8_t>> buffers_;
  std::deque<std::uint32_t> queued_;
};

}  // namespace cairn::camera::testing
