// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace cairn::bus {

/// How a node prints what it also sends as LOG_LINE, in spdlog's terms.
inline constexpr const char* kLogPattern = "%H:%M:%S.%e %^%l%$ %v";

/// Whether a printed line has that form, so that it has been heard on the bus already.
[[nodiscard]] constexpr bool is_log_line(std::string_view line) {
  constexpr std::string_view kForm = "00:00:00.000 ";
  if (line.size() < kForm.size()) return false;
  for (std::size_t i = 0; i < kForm.size(); ++i) {
    const bool fits = kForm[i] == '0' ? line[i] >= '0' && line[i] <= '9' : line[i] == kForm[i];
    if (!fits) return false;
  }
  return true;
}

}  // namespace cairn::bus
