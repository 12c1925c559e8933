// SPDX-License-Identifier: Apache-2.0
#include "simulation/pseudo_terminal.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace cairn::simulation {
namespace {

std::string reason() { return std::strerror(errno); }

Result<void> make_raw(int terminal) {
  termios settings{};
  if (::tcgetattr(terminal, &settings) != 0) return fail("cannot be set up: " + reason());
  ::cfmakeraw(&settings);
  if (::tcsetattr(terminal, TCSANOW, &settings) != 0) return fail("cannot be set up: " + reason());
  return {};
}

// The new link takes the old one's place in one step: whoever opens the name finds either.
Result<void> place_link(const std::filesystem::path& link, const std::filesystem::path& device) {
  std::error_code problem;
  if (link.has_parent_path()) std::filesystem::create_directories(link.parent_path(), problem);
  if (problem) return fail(link.string() + ": its folder cannot be made: " + problem.message());
  const auto there = std::filesystem::symlink_status(link, problem);
  if (std::filesystem::exists(there) && !std::filesystem::is_symlink(there))
    return fail(link.string() + ": is there already and no symbolic link");
  const std::filesystem::path fresh = link.string() + "." + std::to_string(::getpid());
  std::filesystem::remove(fresh, problem);
  std::filesystem::create_symlink(device, fresh, problem);
  if (!problem) std::filesystem::rename(fresh, link, problem);
  if (problem) return fail(link.string() + ": cannot be linked: " + problem.message());
  return {};
}

}  // namespace

Result<std::unique_ptr<PseudoTerminal>> PseudoTerminal::open(const std::filesystem::path& link) {
  const int controller_side = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (controller_side < 0) return fail(link.string() + ": no pseudo-terminal: " + reason());
  std::array<char, 128> name{};
  int host_side = -1;
  if (::grantpt(controller_side) == 0 && ::unlockpt(controller_side) == 0 &&
      ::ptsname_r(controller_side, name.data(), name.size()) == 0) {
    host_side = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  if (host_side < 0) {
    const std::string why = reason();
    ::close(controller_side);
    return fail(link.string() + ": no pseudo-terminal: " + why);
  }
  std::unique_ptr<PseudoTerminal> terminal{
      new PseudoTerminal(controller_side, host_side, link, name.data())};
  if (auto raw = make_raw(host_side); !raw)
    return fail(link.string() + ": pseudo-terminal " + raw.error().message);
  if (auto placed = place_link(link, name.data()); !placed)
    return tl::make_unexpected(placed.error());
  return terminal;
}

PseudoTerminal::PseudoTerminal(int controller_side, int host_side, std::filesystem::path link,
                               std::filesystem::path device)
    : controller_side_{controller_side},
      host_side_{host_side},
      link_{std::move(link)},
      device_{std::move(device)} {}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (std::filesystem::read_symlink(link_, ignored) == device_)
    std::filesystem::remove(link_, ignored);
  ::close(host_side_);
  ::close(controller_side_);
}

Result<std::vector<std::uint8_t>> PseudoTerminal::read() {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 1024> portion{};
  while (true) {
    const ssize_t got = ::read(controller_side_, portion.data(), portion.size());
    if (got > 0) {
      bytes.insert(bytes.end(), portion.begin(), portion.begin() + got);
    } else if (got < 0 && errno == EINTR) {
      continue;
    } else if (got == 0 || errno == EAGAIN) {
      return bytes;
    } else {
      return fail(link_.string() + ": cannot read: " + reason());
    }
  }
}

Result<void> PseudoTerminal::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(controller_side_, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return fail(link_.string() + ": takes no more: " + reason());
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return {};
}

}  // namespace cairn::simulation
