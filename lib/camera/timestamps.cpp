// SPDX-License-Identifier: Apache-2.0
#include "camera/timestamps.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <string>

#include "camera/text_lines.hpp"

namespace cairn::camera {
namespace {

/// Some 30,000 years: no time of a recording lies beyond, and no sum of two overflows.
constexpr double kMaxTime_us = 1e18;

Result<std::int64_t> parse_whole(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    return fail("'" + std::string(text) + "' is not a whole number");
  }
  return value;
}

Result<Utime> rounded(double time_us) {
  if (std::abs(time_us) > kMaxTime_us) return fail("is too large for a time");
  return static_cast<Utime>(std::llround(time_us));
}

Result<Utime> parse_us(std::string_view text) {
  const auto value = parse_whole(text);
  if (!value) return value;
  if (std::abs(static_cast<double>(*value)) > kMaxTime_us) return fail("is too large for a time");
  return *value;
}

Result<Utime> parse_s(std::string_view text) {
  const auto numbers = parse_numbers(text);
  if (!numbers) return tl::make_unexpected(numbers.error());
  if (numbers->size() != 1) return fail("is not one number");
  return rounded(numbers->front() * 1e6);
}

Result<std::vector<Utime>> read_times(const std::filesystem::path& file,
                                      const std::function<Result<Utime>(std::string_view)>& parse) {
  const auto lines = read_lines(file);
  if (!lines) return tl::make_unexpected(lines.error());
  std::vector<Utime> utimes;
  for (const TextLine& line : *lines) {
    const auto utime = parse(line.text);
    if (!utime) return fail(place(file, line) + utime.error().message);
    if (!utimes.empty() && *utime <= utimes.back()) {
      return fail(place(file, line) + "this time does not come after the one before");
    }
    utimes.push_back(*utime);
  }
  return utimes;
}

}  // namespace

Result<Utime> parse_ns(std::string_view text) {
  const auto value = parse_whole(text);
  if (!value) return value;
  if (*value < 0) return fail("'" + std::string(text) + "' lies before time began");
  return *value / 1000 + (*value % 1000 >= 500 ? 1 : 0);
}

Result<std::vector<Utime>> read_times_us(const std::filesystem::path& file) {
  return read_times(file, parse_us);
}

Result<std::vector<Utime>> read_times_s(const std::filesystem::path& file) {
  return read_times(file, parse_s);
}

Result<std::vector<Utime>> times_of_names_ns(const std::vector<std::filesystem::path>& files) {
  std::vector<Utime> utimes;
  for (const auto& file : files) {
    const auto utime = parse_ns(file.stem().string());
    if (!utime)
      return fail(file.string() + ": its name is not a time in ns: " + utime.error().message);
    if (!utimes.empty() && *utime <= utimes.back()) {
      return fail(file.string() + ": this time does not come after the one before");
    }
    utimes.push_back(*utime);
  }
  return utimes;
}

std::vector<Utime> times_at_rate(std::size_t count, double rate_hz) {
  std::vector<Utime> utimes(count);
  for (std::size_t i = 0; i < count; ++i) {
    utimes[i] = std::llround(static_cast<double>(i) * 1e6 / rate_hz);
  }
  return utimes;
}

double nominal_rate_hz(const std::vector<Utime>& utimes) {
  if (utimes.size() < 2) return 1;
  std::vector<Utime> steps_us;
  for (std::size_t i = 1; i < utimes.size(); ++i) steps_us.push_back(utimes[i] - utimes[i - 1]);
  const auto middle = steps_us.begin() + static_cast<std::ptrdiff_t>(steps_us.size() / 2);
  std::nth_element(steps_us.begin(), middle, steps_us.end());
  return 1e6 / static_cast<double>(*middle);
}

}  // namespace cairn::camera
