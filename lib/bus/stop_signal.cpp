// SPDX-License-Identifier: Apache-2.0
#include "bus/stop_signal.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>

namespace cairn::bus {

StopSignal::StopSignal() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGHUP);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  fd_ = ::signalfd(-1, &signals, SFD_NONBLOCK | SFD_CLOEXEC);
  std::signal(SIGPIPE, SIG_IGN);
}

StopSignal::~StopSignal() { ::close(fd_); }

bool StopSignal::arrived(std::int64_t timeout_us) {
  pollfd readable{fd_, POLLIN, 0};
  const timespec wait{timeout_us / 1'000'000, (timeout_us % 1'000'000) * 1000};
  arrived_ = arrived_ || ::ppoll(&readable, 1, &wait, nullptr) > 0;
  return arrived_;
}

}  // namespace cairn::bus
