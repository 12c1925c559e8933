// SPDX-License-Identifier: Apache-2.0
#include "motor/serial_link.hpp"

#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "motor/modem_lines.hpp"

namespace cairn::motor {
namespace {

constexpr std::string_view kPseudoTerminals = "/dev/pts/";
/// A device that never stops sending must not keep its reader for ever.
constexpr std::size_t kMaxAtOnce_bytes = 16'384;

Error problem(const std::filesystem::path& device, const std::string& what) {
  return {device.string() + ": " + what};
}

// To be called at once, before the cause is overwritten.
std::string port_error() {
  char* const text = sp_last_error_message();
  std::string copy = text != nullptr ? text : "unknown";
  sp_free_error_message(text);
  return copy;
}

std::string because(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return "no such device; is the wheel controller connected and on? `ls -l /dev/serial/by-id` "
             "lists serial ports";
    case EACCES:
    case EPERM:
      return "no right to open it; `sudo usermod -aG dialout $USER` and logging in again gives it";
    case ENXIO:
    case ENODEV:
    case EIO:
      return "nothing is connected there";
    default:
      return std::strerror(error);
  }
}

// Says more clearly than libserialport why a device cannot be opened; the value is where the name
// leads to.
Result<std::filesystem::path> find(const std::filesystem::path& device) {
  if (device.empty()) return fail("no serial device is named; set `device`");
  struct stat info {};
  if (::stat(device.c_str(), &info) != 0)
    return tl::make_unexpected(problem(device, because(errno)));
  if (!S_ISCHR(info.st_mode)) return tl::make_unexpected(problem(device, "is no serial device"));
  if (::access(device.c_str(), R_OK | W_OK) != 0)
    return tl::make_unexpected(problem(device, because(errno)));
  std::error_code lost;
  auto target = std::filesystem::canonical(device, lost);
  if (lost) return tl::make_unexpected(problem(device, lost.message()));
  return target;
}

// libserialport 0.1.1 takes only names below /dev/ that sysfs, or a symbolic link that is found the
// same way, knows of. A pseudo-terminal is found by way of the link to it.
std::string name_for_library(const std::filesystem::path& device,
                             const std::filesystem::path& target) {
  if (!target.string().starts_with(kPseudoTerminals)) return target.string();
  answer_for_missing_modem_lines();
  return "/dev/../../.." + std::filesystem::absolute(device).string();
}

}  // namespace

Result<std::unique_ptr<SerialLink>> SerialLink::open(const std::filesystem::path& device,
                                                     int baud) {
  const auto target = find(device);
  if (!target) return tl::make_unexpected(target.error());
  sp_port* port = nullptr;
  if (sp_get_port_by_name(name_for_library(device, *target).c_str(), &port) != SP_OK)
    return tl::make_unexpected(problem(device, "is no serial device (" + port_error() + ")"));
  std::unique_ptr<SerialLink> link{new SerialLink(device, port)};
  if (sp_open(port, SP_MODE_READ_WRITE) != SP_OK)
    return tl::make_unexpected(problem(device, "cannot be opened: " + port_error()));
  if (auto ready = link->set_up(baud); !ready) return tl::make_unexpected(ready.error());
  return link;
}

Result<void> SerialLink::set_up(int baud) {
  int fd = -1;
  if (sp_get_port_handle(port_, &fd) != SP_OK || ::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return tl::make_unexpected(problem(
        device_, "is in use by another program; `fuser " + device_.string() + "` names it"));
  }
  if (sp_set_baudrate(port_, baud) != SP_OK || sp_set_bits(port_, 8) != SP_OK ||
      sp_set_parity(port_, SP_PARITY_NONE) != SP_OK || sp_set_stopbits(port_, 1) != SP_OK ||
      sp_set_flowcontrol(port_, SP_FLOWCONTROL_NONE) != SP_OK) {
    return tl::make_unexpected(
        problem(device_, "cannot be set to " + std::to_string(baud) + " baud: " + port_error()));
  }
  if (sp_flush(port_, SP_BUF_BOTH) != SP_OK)
    return tl::make_unexpected(problem(device_, "cannot be flushed: " + port_error()));
  return {};
}

SerialLink::~SerialLink() {
  sp_close(port_);
  sp_free_port(port_);
}

// A port that was pulled out reads as one where nothing comes; only poll tells.
Result<void> SerialLink::still_there() const {
  pollfd wait{-1, POLLIN, 0};
  if (sp_get_port_handle(port_, &wait.fd) != SP_OK)
    return tl::make_unexpected(problem(device_, "is closed"));
  if (::poll(&wait, 1, 0) > 0 && (wait.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0)
    return tl::make_unexpected(problem(device_, "is gone"));
  return {};
}

Result<std::vector<std::uint8_t>> SerialLink::read() {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 1024> portion{};
  while (bytes.size() < kMaxAtOnce_bytes) {
    const int got = sp_nonblocking_read(port_, portion.data(), portion.size());
    if (got < 0) return tl::make_unexpected(problem(device_, "cannot be read: " + port_error()));
    bytes.insert(bytes.end(), portion.begin(), portion.begin() + got);
    if (static_cast<std::size_t>(got) < portion.size()) break;
  }
  if (auto there = still_there(); !there) return tl::make_unexpected(there.error());
  return bytes;
}

Result<void> SerialLink::write(std::span<const std::uint8_t> bytes) {
  const int put = sp_nonblocking_write(port_, bytes.data(), bytes.size());
  if (put < 0) return tl::make_unexpected(problem(device_, "cannot be written: " + port_error()));
  if (static_cast<std::size_t>(put) < bytes.size())
    return tl::make_unexpected(problem(device_, "takes no more"));
  return {};
}

}  // namespace cairn::motor
