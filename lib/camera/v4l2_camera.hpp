// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "camera/v4l2_config.hpp"
#include "camera/v4l2_device.hpp"
#include "core/result.hpp"
#include "core/time.hpp"

namespace cairn::camera {

/// Reads the monotonic clock that the kernel stamps frames with.
using MonotonicClock = std::function<HostTime()>;

/// One V4L2 camera. Every error names the device and the step, control or format that the driver
/// refused.
class V4l2Camera {
 public:
  V4l2Camera(const std::string& side, std::string device_path, const V4l2Config& config,
             std::unique_ptr<V4l2Device> device);
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;
  ~V4l2Camera();

  /// Opens the device, agrees on format and rate, locks what is to be locked, and starts the
  /// stream.
  [[nodiscard]] Result<void> start();
  /// Gives everything back; start() begins anew.
  void stop();

  /// Takes the next image off the driver, unless one is held already: true when one is held, false
  /// when none came by `deadline`. An error means that the device is out: stop it.
  [[nodiscard]] Result<bool> grab(HostTime deadline, const MonotonicClock& clock);
  /// Capture time of the image held.
  [[nodiscard]] HostTime grabbed_at() const { return held_->at; }
  /// The image held, as grey CV_8UC1. An error (half an image, damage) concerns this image alone.
  [[nodiscard]] Result<cv::Mat> retrieve() const;
  /// Gives the buffer held back to the driver.
  [[nodiscard]] Result<void> release();

  /// As the driver says after start().
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  /// As the driver says after start(); 0 where it is automatic or unknown.
  [[nodiscard]] int exposure_us() const { return exposure_us_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  struct Held {
    std::uint32_t buffer = 0;
    std::size_t used_bytes = 0;
    bool damaged = false;
    HostTime at = 0;
  };
  struct Control {
    std::uint32_t id = 0;
    const char* name = "";
    int value = 0;
  };

  [[nodiscard]] Result<void> open();
  [[nodiscard]] Result<void> check_capabilities();
  [[nodiscard]] Result<void> choose_format();
  [[nodiscard]] Result<bool> try_format(std::uint32_t format);
  [[nodiscard]] Result<void> choose_rate();
  [[nodiscard]] Result<void> lock_controls();
  [[nodiscard]] Result<bool> set_control(const Control& control);
  [[nodiscard]] Result<void> read_exposure();
  [[nodiscard]] Result<void> map_buffers();
  [[nodiscard]] Result<void> queue(std::uint32_t buffer);
  [[nodiscard]] Result<void> start_stream();
  [[nodiscard]] Result<bool> dequeue();
  [[nodiscard]] tl::unexpected<Error> refused(const std::string& step, int negative_errno) const;

  std::string name_;
  std::string path_;
  V4l2Config config_;
  std::unique_ptr<V4l2Device> device_;
  std::vector<std::span<std::uint8_t>> buffers_;
  std::optional<Held> held_;
  bool streaming_ = false;
  std::uint32_t format_ = 0;
  std::size_t row_bytes_ = 0;
  double rate_hz_ = 0;
  int exposure_us_ = 0;
};

}  // namespace cairn::camera
