// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/quantities.hpp"

#include <cmath>
#include <cstdio>

namespace cairn::spy {
namespace {

/// Three digits: "1.23", "12.3", "123".
std::string three_digits(double value) {
  const double size = std::abs(value);
  const int decimals = size < 9.995 ? 2 : (size < 99.95 ? 1 : 0);
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

}  // namespace

std::string grouped(std::int64_t value) {
  std::string digits = std::to_string(value);
  const std::size_t sign = digits[0] == '-' ? 1 : 0;
  for (std::size_t at = digits.size(); at > sign + 3;) {
    at -= 3;
    digits.insert(at, ",");
  }
  return digits;
}

std::string bytes_text(double bytes) {
  if (bytes < 1e3) return std::to_string(std::llround(bytes)) + " B";
  if (bytes < 1e6) return three_digits(bytes / 1e3) + " kB";
  if (bytes < 1e9) return three_digits(bytes / 1e6) + " MB";
  return three_digits(bytes / 1e9) + " GB";
}

std::string duration_text(double duration_us) {
  if (duration_us < 1e3) return std::to_string(std::llround(duration_us)) + " us";
  if (duration_us < 1e6) return three_digits(duration_us / 1e3) + " ms";
  if (duration_us < 120e6) return three_digits(duration_us / 1e6) + " s";
  if (duration_us < 7200e6) return std::to_string(std::llround(duration_us / 60e6)) + " min";
  return three_digits(duration_us / 3600e6) + " h";
}

std::string rate_text(double rate_hz) { return three_digits(rate_hz); }

}  // namespace cairn::spy
