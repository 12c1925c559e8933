// SPDX-License-Identifier: Apache-2.0
#include "motor/device_time.hpp"

#include <algorithm>
#include <vector>

namespace cairn::motor {
namespace {

constexpr std::size_t kShareBelow = 8;

}  // namespace

void DeviceTime::tick(Utime utime, double rate, HostTime sent_us) {
  if (tick_ && utime < tick_->utime - kJump_us) {
    differences_.clear();
    last_stamp_ = 0;
  } else if (tick_) {
    const auto since_us = static_cast<double>(std::max<HostTime>(0, sent_us - tick_->sent_us));
    const double ahead_us = static_cast<double>(utime - tick_->utime) - tick_->rate * since_us;
    if (ahead_us > static_cast<double>(kJump_us)) differences_.clear();
  }
  tick_ = Tick{utime, rate, sent_us};
}

Utime DeviceTime::data_now(HostTime now_us) const {
  if (!tick_) return 0;
  const auto since_us = std::clamp<HostTime>(now_us - tick_->sent_us, 0, kMaxExtension_us);
  return tick_->utime + static_cast<Utime>(tick_->rate * static_cast<double>(since_us));
}

// While data time stands still for long, nothing is to be learned.
void DeviceTime::learn(std::int64_t device_us, HostTime now_us) {
  if (now_us - tick_->sent_us > kMaxExtension_us && !differences_.empty()) return;
  differences_.push_back({device_us, data_now(now_us) - device_us});
  while (differences_.size() > kMaxReadings ||
         differences_.front().device_us < device_us - kWindow_us) {
    differences_.pop_front();
  }
}

std::int64_t DeviceTime::data_minus_device_us() const {
  std::vector<std::int64_t> sorted;
  sorted.reserve(differences_.size());
  for (const Difference& difference : differences_)
    sorted.push_back(difference.data_minus_device_us);
  const auto truest = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / kShareBelow);
  std::nth_element(sorted.begin(), truest, sorted.end());
  return *truest;
}

Utime DeviceTime::stamp(std::int64_t device_us, HostTime now_us) {
  if (!tick_) return 0;
  learn(device_us, now_us);
  last_stamp_ = std::max(last_stamp_ + 1, device_us + data_minus_device_us());
  return last_stamp_;
}

}  // namespace cairn::motor
