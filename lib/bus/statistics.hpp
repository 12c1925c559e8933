// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn::bus {

/// The newest thousand durations of something, for percentiles.
class DurationStatistics {
 public:
  void add(std::int64_t duration_us) {
    if (samples_.size() < kCapacity) {
      samples_.push_back(duration_us);
    } else {
      samples_[next_++ % kCapacity] = duration_us;
    }
  }

  /// The smallest sample that is at least as large as `share` of all (nearest rank); 0 without
  /// samples.
  [[nodiscard]] std::int64_t percentile_us(double share) const {
    if (samples_.empty()) return 0;
    std::vector<std::int64_t> sorted = samples_;
    const auto rank =
        static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5);
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(rank),
                     sorted.end());
    return sorted[rank];
  }

 private:
  static constexpr std::size_t kCapacity = 1000;
  std::vector<std::int64_t> samples_;
  std::size_t next_ = 0;
};

}  // namespace cairn::bus
