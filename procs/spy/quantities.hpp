// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace cairn::spy {

/// 1234567 -> "1,234,567".
[[nodiscard]] std::string grouped(std::int64_t value);

/// Bytes with three digits or so: "512 B", "1.23 kB", "45.6 MB"; steps of 1000.
[[nodiscard]] std::string bytes_text(double bytes);

/// A duration with three digits or so: "85 us", "1.23 ms", "45.6 s", "12 min", "3.4 h".
[[nodiscard]] std::string duration_text(double duration_us);

/// A rate with three digits or so: "30.0", "0.25".
[[nodiscard]] std::string rate_text(double rate_hz);

}  // namespace cairn::spy
