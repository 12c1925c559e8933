// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/pace.hpp"

#include <algorithm>
#include <cmath>

#include "core/time.hpp"
#include "procs/spy/saturating.hpp"

namespace cairn::spy {
namespace {

constexpr std::int64_t kWindow_us = 2 * kMicrosecondsPerSecond;
constexpr std::size_t kFewestIntervals = 10;
constexpr std::size_t kMostIntervals = 20'000;

}  // namespace

void PaceMeter::Sums::add(const Arrival& arrival) {
  min_us = count == 0 ? arrival.interval_us : std::min(min_us, arrival.interval_us);
  max_us = std::max(max_us, arrival.interval_us);
  ++count;
  span_us = saturating_sum(span_us, arrival.interval_us);
  bytes += arrival.bytes;
  const double interval_us = static_cast<double>(arrival.interval_us);
  const double off_us = interval_us - mean_us;
  mean_us += off_us / static_cast<double>(count);
  squares_us2 += off_us * (interval_us - mean_us);
}

void PaceMeter::add(std::int64_t time_us, std::size_t bytes) {
  const auto before_us = last_us_;
  last_us_ = time_us;
  if (!before_us || time_us < *before_us) return;
  const Arrival arrival{time_us, saturating_difference(time_us, *before_us),
                        static_cast<std::int64_t>(bytes)};
  if (window_ == PaceWindow::kWhole) return whole_.add(arrival);
  newest_.push_back(arrival);
  forget_old(time_us);
}

void PaceMeter::forget_old(std::int64_t now_us) {
  while (newest_.size() > kMostIntervals || (newest_.size() > kFewestIntervals &&
                                             age(now_us, newest_.front().time_us) >= kWindow_us)) {
    newest_.pop_front();
  }
}

std::optional<Pace> PaceMeter::pace(std::int64_t now_us) const {
  Sums sums = whole_;
  for (const Arrival& arrival : newest_) sums.add(arrival);
  if (sums.span_us == 0) return std::nullopt;
  const std::int64_t silence_us = age(age(now_us, *last_us_), sums.max_us);
  const double span_s = to_seconds(saturating_sum(sums.span_us, silence_us));
  Pace pace;
  pace.intervals = sums.count;
  pace.rate_hz = static_cast<double>(sums.count) / span_s;
  pace.bytes_per_s = static_cast<double>(sums.bytes) / span_s;
  pace.min_interval_us = static_cast<double>(sums.min_us);
  pace.mean_interval_us = sums.mean_us;
  pace.max_interval_us = static_cast<double>(sums.max_us);
  pace.std_interval_us = std::sqrt(sums.squares_us2 / static_cast<double>(sums.count));
  return pace;
}

}  // namespace cairn::spy
