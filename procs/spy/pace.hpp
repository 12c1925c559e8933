// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace cairn::spy {

/// How messages follow each other. Intervals are those between arrivals of one channel.
struct Pace {
  std::int64_t intervals = 0;
  double rate_hz =
      0;  ///< falls as soon as the channel is silent for longer than its longest interval
  double min_interval_us = 0;
  double mean_interval_us = 0;
  double max_interval_us = 0;
  double std_interval_us = 0;  ///< of all of them, not of a sample
  double bytes_per_s = 0;
};

/// Over how much of the past a pace is taken.
enum class PaceWindow {
  kNewest,  ///< the newest two seconds, or the newest ten intervals where those reach further back
  kWhole    ///< everything
};

/// Takes the pace of one channel. Time that goes back makes no interval.
class PaceMeter {
 public:
  explicit PaceMeter(PaceWindow window) : window_{window} {}

  void add(std::int64_t time_us, std::size_t bytes);

  /// Nothing before an interval was seen; messages that came all at once have no pace.
  [[nodiscard]] std::optional<Pace> pace(std::int64_t now_us) const;

 private:
  struct Arrival {
    std::int64_t time_us;
    std::int64_t interval_us;
    std::int64_t bytes;
  };
  /// Running sums (Welford 1962).
  struct Sums {
    std::int64_t count = 0;
    std::int64_t span_us = 0;
    std::int64_t bytes = 0;
    double mean_us = 0;
    double squares_us2 = 0;
    std::int64_t min_us = 0;
    std::int64_t max_us = 0;
    void add(const Arrival& arrival);
  };
  void forget_old(std::int64_t now_us);

  PaceWindow window_;
  std::optional<std::int64_t> last_us_;
  Sums whole_;
  std::deque<Arrival> newest_;
};

}  // namespace cairn::spy
