// SPDX-License-Identifier: Apache-2.0
#include "camera/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include "camera/image_decoding.hpp"

namespace cairn::camera {
namespace {

constexpr std::uint32_t kBuffers = 4;
constexpr std::uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
constexpr int kExposureUnit_us = 100;

struct KnownFormat {
  const char* name;
  std::uint32_t code;
  std::size_t pixel_bytes;  ///< 0: compressed
};
constexpr std::array<KnownFormat, 3> kFormats{{
    {"grey", V4L2_PIX_FMT_GREY, 1},
    {"yuyv", V4L2_PIX_FMT_YUYV, 2},
    {"mjpg", V4L2_PIX_FMT_MJPEG, 0},
}};

std::size_t pixel_bytes(std::uint32_t code) {
  for (const KnownFormat& format : kFormats) {
    if (format.code == code) return format.pixel_bytes;
  }
  return 0;
}

std::string four_letters(std::uint32_t code) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) {
    const char letter = static_cast<char>(code >> shift);
    text += letter >= ' ' && letter <= '~' ? letter : '?';
  }
  return text;
}

v4l2_buffer capture_buffer(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = kCapture;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

V4l2Camera::V4l2Camera(const std::string& side, std::string device_path, const V4l2Config& config,
                       std::unique_ptr<V4l2Device> device)
    : name_{side + " camera " + device_path},
      path_{std::move(device_path)},
      config_{config},
      device_{std::move(device)},
      rate_hz_{config.rate_hz} {}

V4l2Camera::~V4l2Camera() { stop(); }

Result<void> V4l2Camera::start() {
  stop();
  for (const auto step :
       {&V4l2Camera::open, &V4l2Camera::check_capabilities, &V4l2Camera::choose_format,
        &V4l2Camera::choose_rate, &V4l2Camera::lock_controls, &V4l2Camera::read_exposure,
        &V4l2Camera::map_buffers, &V4l2Camera::start_stream}) {
    if (auto done = (this->*step)(); !done) {
      stop();
      return done;
    }
  }
  return {};
}

void V4l2Camera::stop() {
  if (streaming_) {
    int type = kCapture;
    (void)device_->ioctl(VIDIOC_STREAMOFF,
                         &type);  // an unplugged device refuses; it is closed all the same
  }
  streaming_ = false;
  held_.reset();
  for (const auto& buffer : buffers_) device_->munmap(buffer);
  buffers_.clear();
  device_->close();
}

Result<bool> V4l2Camera::grab(HostTime deadline, const MonotonicClock& clock) {
  while (!held_) {
    const std::int64_t left_us = std::max<std::int64_t>(0, deadline - clock());
    const int ready = device_->poll(static_cast<int>((left_us + 999) / 1000));
    if (ready < 0 && ready != -EINTR) return refused("poll", ready);
    if (ready > 0) {
      if (auto taken = dequeue(); !taken || *taken) return taken;
    }
    if (clock() >= deadline) return false;
  }
  return true;
}

Result<cv::Mat> V4l2Camera::retrieve() const {
  const std::span<const std::uint8_t> bytes =
      std::span<const std::uint8_t>(buffers_[held_->buffer]).first(held_->used_bytes);
  if (held_->damaged) return fail(name_ + ": the driver marks an image as damaged");
  const std::size_t pixel = pixel_bytes(format_);
  if (pixel == 0) {
    auto image = decode_grey(bytes);
    if (!image) return fail(name_ + ": an image " + image.error().message);
    if (image->cols != config_.width_px || image->rows != config_.height_px) {
      return fail(name_ + ": an image is " + std::to_string(image->cols) + " x " +
                  std::to_string(image->rows) + " pixels");
    }
    return image;
  }
  const std::size_t whole = row_bytes_ * static_cast<std::size_t>(config_.height_px - 1) +
                            pixel * static_cast<std::size_t>(config_.width_px);
  if (bytes.size() < whole) {
    return fail(name_ + ": half an image: " + std::to_string(bytes.size()) + " of " +
                std::to_string(whole) + " bytes");
  }
  const cv::Mat packed(config_.height_px, config_.width_px,
                       CV_MAKETYPE(CV_8U, static_cast<int>(pixel)),
                       const_cast<std::uint8_t*>(bytes.data()), row_bytes_);
  cv::Mat grey;
  cv::extractChannel(packed, grey, 0);
  return grey;
}

Result<void> V4l2Camera::release() {
  if (!held_) return {};
  const std::uint32_t buffer = held_->buffer;
  held_.reset();
  return queue(buffer);
}

Result<void> V4l2Camera::open() {
  const int opened = device_->open(path_);
  if (opened < 0) return refused("open", opened);
  return {};
}

Result<void> V4l2Camera::check_capabilities() {
  v4l2_capability capability{};
  if (const int asked = device_->ioctl(VIDIOC_QUERYCAP, &capability); asked < 0) {
    return refused("VIDIOC_QUERYCAP (is it a camera?)", asked);
  }
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                ? capability.device_caps
                                : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) return fail(name_ + ": cannot capture video");
  if ((can & V4L2_CAP_STREAMING) == 0) return fail(name_ + ": cannot stream into memory");
  return {};
}

Result<void> V4l2Camera::choose_format() {
  std::vector<std::uint32_t> offered;
  std::string offered_names;
  v4l2_fmtdesc description{};
  description.type = kCapture;
  while (device_->ioctl(VIDIOC_ENUM_FMT, &description) >= 0 && offered.size() < 256) {
    offered.push_back(description.pixelformat);
    offered_names += " " + four_letters(description.pixelformat);
    ++description.index;
  }
  for (const KnownFormat& format : kFormats) {
    if (config_.format != "any" && config_.format != format.name) continue;
    if (std::find(offered.begin(), offered.end(), format.code) == offered.end()) continue;
    const auto agreed = try_format(format.code);
    if (!agreed) return tl::make_unexpected(agreed.error());
    if (*agreed) return {};
  }
  return fail(name_ + ": no format fits: wanted " +
              (config_.format == "any" ? "grey, yuyv or mjpg" : config_.format) + " at " +
              std::to_string(config_.width_px) + " x " + std::to_string(config_.height_px) +
              " pixels; the driver offers" + (offered.empty() ? " none" : offered_names) +
              (offered.empty() ? "" : ", or not at this size"));
}

/// False: the driver would rather give another format or size.
Result<bool> V4l2Camera::try_format(std::uint32_t code) {
  v4l2_format format{};
  format.type = kCapture;
  format.fmt.pix.width = static_cast<std::uint32_t>(config_.width_px);
  format.fmt.pix.height = static_cast<std::uint32_t>(config_.height_px);
  format.fmt.pix.pixelformat = code;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (const int set = device_->ioctl(VIDIOC_S_FMT, &format); set < 0) {
    return refused("VIDIOC_S_FMT " + four_letters(code), set);
  }
  const v4l2_pix_format& pix = format.fmt.pix;
  if (pix.pixelformat != code || pix.width != static_cast<std::uint32_t>(config_.width_px) ||
      pix.height != static_cast<std::uint32_t>(config_.height_px)) {
    return false;
  }
  format_ = code;
  row_bytes_ = std::max<std::size_t>(pix.bytesperline, pixel_bytes(code) * pix.width);
  return true;
}

Result<void> V4l2Camera::choose_rate() {
  v4l2_streamparm parameters{};
  parameters.type = kCapture;
  parameters.parm.capture.timeperframe = {
      1000, static_cast<std::uint32_t>(std::lround(1000 * config_.rate_hz))};
  const int set = device_->ioctl(VIDIOC_S_PARM, &parameters);
  rate_hz_ = config_.rate_hz;
  if (set == -ENOTTY || set == -EINVAL) return {};  // a driver with one rate has no such call
  if (set < 0) return refused("VIDIOC_S_PARM " + std::to_string(config_.rate_hz) + " Hz", set);
  const v4l2_fract& period = parameters.parm.capture.timeperframe;
  if (period.numerator != 0 && period.denominator != 0) {
    rate_hz_ = static_cast<double>(period.denominator) / period.numerator;
  }
  return {};
}

Result<void> V4l2Camera::lock_controls() {
  const bool manual_exposure = config_.exposure_us > 0;
  const bool manual_white = config_.white_balance_k > 0;
  std::vector<Control> controls{
      {V4L2_CID_EXPOSURE_AUTO, "auto_exposure",
       manual_exposure ? V4L2_EXPOSURE_MANUAL : V4L2_EXPOSURE_APERTURE_PRIORITY},
      {V4L2_CID_EXPOSURE_AUTO_PRIORITY, "exposure_dynamic_framerate", 0},
      {V4L2_CID_AUTO_WHITE_BALANCE, "white_balance_automatic", manual_white ? 0 : 1}};
  if (manual_exposure) {
    controls.push_back({V4L2_CID_EXPOSURE_ABSOLUTE, "exposure_time_absolute",
                        (config_.exposure_us + kExposureUnit_us / 2) / kExposureUnit_us});
  }
  if (manual_white) {
    controls.push_back(
        {V4L2_CID_WHITE_BALANCE_TEMPERATURE, "white_balance_temperature", config_.white_balance_k});
  }
  if (config_.gain >= 0) {
    controls.push_back({V4L2_CID_AUTOGAIN, "gain_automatic", 0});
    controls.push_back({V4L2_CID_GAIN, "gain", config_.gain});
  }
  for (const Control& control : controls) {
    if (auto set = set_control(control); !set) return tl::make_unexpected(set.error());
  }
  return {};
}

/// False: the driver does not have the control.
Result<bool> V4l2Camera::set_control(const Control& control) {
  v4l2_queryctrl query{};
  query.id = control.id;
  const int asked = device_->ioctl(VIDIOC_QUERYCTRL, &query);
  if (asked == -EINVAL || asked == -ENOTTY) return false;
  if (asked < 0) return refused(std::string("VIDIOC_QUERYCTRL ") + control.name, asked);
  if ((query.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) != 0) return false;
  if (control.value < query.minimum || control.value > query.maximum) {
    return fail(name_ + ": " + control.name + ": " + std::to_string(control.value) +
                " is wanted, the driver allows " + std::to_string(query.minimum) + " to " +
                std::to_string(query.maximum));
  }
  v4l2_control value{control.id, control.value};
  if (const int set = device_->ioctl(VIDIOC_S_CTRL, &value); set < 0) {
    return refused(std::string(control.name) + " = " + std::to_string(control.value), set);
  }
  return true;
}

Result<void> V4l2Camera::read_exposure() {
  exposure_us_ = 0;
  if (config_.exposure_us == 0) return {};
  v4l2_control value{V4L2_CID_EXPOSURE_ABSOLUTE, 0};
  const int read = device_->ioctl(VIDIOC_G_CTRL, &value);
  if (read == -EINVAL || read == -ENOTTY) return {};
  if (read < 0) return refused("exposure_time_absolute", read);
  exposure_us_ = std::clamp(value.value, 0, 10'000'000) * kExposureUnit_us;
  return {};
}

Result<void> V4l2Camera::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = kCapture;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int made = device_->ioctl(VIDIOC_REQBUFS, &request); made < 0) {
    return refused("VIDIOC_REQBUFS", made);
  }
  if (request.count < 2) return fail(name_ + ": the driver has too few buffers");
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = capture_buffer(i);
    if (const int asked = device_->ioctl(VIDIOC_QUERYBUF, &buffer); asked < 0) {
      return refused("VIDIOC_QUERYBUF", asked);
    }
    std::span<std::uint8_t> mapped;
    if (const int made = device_->mmap(buffer.length, buffer.m.offset, mapped); made < 0) {
      return refused("mmap", made);
    }
    buffers_.push_back(mapped);
    if (auto queued = queue(i); !queued) return queued;
  }
  return {};
}

Result<void> V4l2Camera::queue(std::uint32_t index) {
  v4l2_buffer buffer = capture_buffer(index);
  if (const int queued = device_->ioctl(VIDIOC_QBUF, &buffer); queued < 0) {
    return refused("VIDIOC_QBUF", queued);
  }
  return {};
}

Result<void> V4l2Camera::start_stream() {
  int type = kCapture;
  const int started = device_->ioctl(VIDIOC_STREAMON, &type);
  if (started == -ENOSPC) {
    return fail(name_ +
                ": VIDIOC_STREAMON: the USB controller has no bandwidth left: use format "
                "mjpg, a lower rate_hz, or another controller for one camera");
  }
  if (started < 0) return refused("VIDIOC_STREAMON", started);
  streaming_ = true;
  return {};
}

/// False: nothing to take after all.
Result<bool> V4l2Camera::dequeue() {
  v4l2_buffer buffer = capture_buffer(0);
  const int taken = device_->ioctl(VIDIOC_DQBUF, &buffer);
  if (taken == -EAGAIN) return false;
  if (taken < 0) return refused("VIDIOC_DQBUF", taken);
  if (buffer.index >= buffers_.size())
    return fail(name_ + ": the driver gave a buffer it never had");
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    return fail(name_ + ": the driver does not stamp images with the monotonic clock");
  }
  Held held;
  held.buffer = buffer.index;
  held.used_bytes = std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].size());
  held.damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  held.at = static_cast<HostTime>(buffer.timestamp.tv_sec) * kMicrosecondsPerSecond +
            buffer.timestamp.tv_usec;
  held_ = held;
  return true;
}

tl::unexpected<Error> V4l2Camera::refused(const std::string& step, int negative_errno) const {
  return fail(name_ + ": " + step + ": " + std::generic_category().message(-negative_errno));
}

}  // namespace cairn::camera
