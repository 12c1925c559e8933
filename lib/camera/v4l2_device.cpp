// SPDX-License-Identifier: Apache-2.0
#include "camera/v4l2_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace cairn::camera {
namespace {

class LinuxV4l2Device : public V4l2Device {
 public:
  LinuxV4l2Device() = default;
  LinuxV4l2Device(const LinuxV4l2Device&) = delete;
  LinuxV4l2Device& operator=(const LinuxV4l2Device&) = delete;
  ~LinuxV4l2Device() override { shut(); }

  int open(const std::string& path) override {
    shut();
    descriptor_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return descriptor_ < 0 ? -errno : 0;
  }

  int ioctl(unsigned long request, void* argument) override {
    int result = -1;
    do {
      result = ::ioctl(descriptor_, request, argument);
    } while (result < 0 && errno == EINTR);
    return result < 0 ? -errno : result;
  }

  int mmap(std::size_t length, std::int64_t offset, std::span<std::uint8_t>& mapped) override {
    void* start = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, offset);
    if (start == MAP_FAILED) return -errno;
    mapped = {static_cast<std::uint8_t*>(start), length};
    return 0;
  }

  void munmap(std::span<std::uint8_t> mapped) override { ::munmap(mapped.data(), mapped.size()); }

  int poll(int timeout_ms) override {
    pollfd request{descriptor_, POLLIN, 0};
    const int ready = ::poll(&request, 1, timeout_ms);
    return ready < 0 ? -errno : ready;
  }

  void close() override { shut(); }

 private:
  void shut() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }

  int descriptor_ = -1;
};

}  // namespace

std::unique_ptr<V4l2Device> linux_v4l2_device() { return std::make_unique<LinuxV4l2Device>(); }

}  // namespace cairn::camera
