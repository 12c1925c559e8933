// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/progress_line.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace cairn::cli {
namespace {

constexpr std::int64_t kTerminalPeriod_us = 200'000;
constexpr std::int64_t kPlainPeriod_us = 10 * kMicrosecondsPerSecond;

std::size_t terminal_width() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1U : 79U;
}

}  // namespace

ProgressLine::ProgressLine() : terminal_{::isatty(STDERR_FILENO) != 0} {}

ProgressLine::~ProgressLine() {
  if (terminal_ && next_us_ > 0) std::fprintf(stderr, "\r\033[K");
}

bool ProgressLine::due(HostTime now_us) const { return now_us >= next_us_; }

void ProgressLine::show(const std::string& text, HostTime now_us) {
  if (!due(now_us)) return;
  next_us_ = now_us + (terminal_ ? kTerminalPeriod_us : kPlainPeriod_us);
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K%s", text.substr(0, terminal_width()).c_str());
  } else {
    std::fprintf(stderr, "%s\n", text.c_str());
  }
}

}  // namespace cairn::cli
