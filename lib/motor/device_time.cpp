// SPDX-License-Identifier: Apache-2.0
#include "motor/device_time.hpp"

#include <algorithm>
#include <cstdlib>

namespace cairn::motor {

void DeviceTime::tick(Utime utime, double rate, HostTime sent_us) {
  if (tick_) {
    const double expected_us =
        static_cast<double>(tick_->utime) +
        tick_->rate * static_cast<double>(std::max<HostTime>(0, sent_us - tick_->sent_us));
    if (std::abs(static_cast<double>(utime) - expected_us) > static_cast<double>(kJump_us)) {
      differences_.clear();
      last_stamp_ = 0;
    }
  }
  tick_ = Tick{utime, rate, sent_us};
}

Utime DeviceTime::data_now(HostTime now_us) const {
  if (!tick_) return 0;
  const auto since_us = std::clamp<HostTime>(now_us - tick_->sent_us, 0, kMaxExtension_us);
  return tick_->utime + static_cast<Utime>(tick_->rate * static_cast<double>(since_us));
}

void DeviceTime::learn(std::int64_t device_us, HostTime now_us) {
  if (now_us - tick_->sent_us > kMaxExtension_us && !differences_.empty()) return;
  const std::int64_t difference_us = data_now(now_us) - device_us;
  while (!differences_.empty() && differences_.back().data_minus_device_us >= difference_us)
    differences_.pop_back();
  differences_.push_back({device_us, difference_us});
  while (differences_.front().device_us < device_us - kWindow_us) differences_.pop_front();
}

Utime DeviceTime::stamp(std::int64_t device_us, HostTime now_us) {
  if (!tick_) return 0;
  learn(device_us, now_us);
  last_stamp_ = std::max(last_stamp_ + 1, device_us + differences_.front().data_minus_device_us);
  return last_stamp_;
}

}  // namespace cairn::motor
