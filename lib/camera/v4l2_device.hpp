// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace cairn::camera {

/// The system calls that a capture needs, so that tests can answer them in a camera's stead. Each
/// returns a negative errno on failure, 0 or more otherwise.
class V4l2Device {
 public:
  virtual ~V4l2Device() = default;
  [[nodiscard]] virtual int open(const std::string& path) = 0;
  /// A VIDIOC_ request of <linux/videodev2.h> with its argument.
  [[nodiscard]] virtual int ioctl(unsigned long request, void* argument) = 0;
  [[nodiscard]] virtual int mmap(std::size_t length, std::int64_t offset,
                                 std::span<std::uint8_t>& mapped) = 0;
  virtual void munmap(std::span<std::uint8_t> mapped) = 0;
  /// 1 when a buffer can be taken, or the device has something to complain of; 0 after timeout_ms
  /// without.
  [[nodiscard]] virtual int poll(int timeout_ms) = 0;
  virtual void close() = 0;
};

/// The Linux kernel's.
[[nodiscard]] std::unique_ptr<V4l2Device> linux_v4l2_device();

}  // namespace cairn::camera
