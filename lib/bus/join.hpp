// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "core/time.hpp"

namespace cairn::bus {

/// Pairs messages of two channels by utime, never by arrival. Pairs come out in rising order of
/// utime; what is older than a pair that came out has missed its chance. Data time set back by more
/// than a second begins anew.
template <class First, class Second>
class Join {
 public:
  void put_first(First message) { put(firsts_, std::move(message)); }
  void put_second(Second message) { put(seconds_, std::move(message)); }

  /// The next pair, if it is complete.
  [[nodiscard]] std::optional<std::pair<First, Second>> take() {
    for (auto first = firsts_.begin(); first != firsts_.end(); ++first) {
      const auto second = seconds_.find(first->first);
      if (second == seconds_.end()) continue;
      last_taken_ = first->first;
      std::pair<First, Second> pair{std::move(first->second), std::move(second->second)};
      firsts_.erase(firsts_.begin(), std::next(first));
      seconds_.erase(seconds_.begin(), std::next(second));
      return pair;
    }
    return std::nullopt;
  }

 private:
  /// How many may wait for their partner: four seconds at 15 Hz.
  static constexpr std::size_t kCapacity = 64;

  template <class Message>
  void put(std::map<Utime, Message>& side, Message message) {
    const Utime utime = message.header.utime;
    if (last_taken_ && utime < *last_taken_ - kMicrosecondsPerSecond) {
      firsts_.clear();
      seconds_.clear();
      last_taken_.reset();
    }
    if (last_taken_ && utime <= *last_taken_) return;
    side.insert_or_assign(utime, std::move(message));
    if (side.size() > kCapacity) side.erase(side.begin());
  }

  std::map<Utime, First> firsts_;
  std::map<Utime, Second> seconds_;
  std::optional<Utime> last_taken_;
};

}  // namespace cairn::bus
