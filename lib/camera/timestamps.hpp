// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "core/time.hpp"

namespace cairn::camera {

/// A whole number of nanoseconds, rounded to microseconds.
[[nodiscard]] Result<Utime> parse_ns(std::string_view text);

/// One time a line, rising strictly; errors name file and line.
[[nodiscard]] Result<std::vector<Utime>> read_times_us(const std::filesystem::path& file);
[[nodiscard]] Result<std::vector<Utime>> read_times_s(const std::filesystem::path& file);

/// The times that the names of the files are, in nanoseconds; they must rise strictly.
[[nodiscard]] Result<std::vector<Utime>> times_of_names_ns(
    const std::vector<std::filesystem::path>& files);

/// Frame i at i / rate, rounded to microseconds.
[[nodiscard]] std::vector<Utime> times_at_rate(std::size_t count, double rate_hz);

/// Frames per second by the median step; 1 for a single frame.
[[nodiscard]] double nominal_rate_hz(const std::vector<Utime>& utimes);

}  // namespace cairn::camera
