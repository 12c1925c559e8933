// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace cairn::motor {

/// What somebody sent as a name or a reason, fit for a log line, a terminal or a file: cut after 64
/// bytes, and with a question mark for what is no printable ASCII.
[[nodiscard]] inline std::string plain_text(const std::string& text) {
  constexpr std::size_t kMax_bytes = 64;
  std::string plain = text.substr(0, kMax_bytes);
  std::replace_if(
      plain.begin(), plain.end(), [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
  return plain;
}

}  // namespace cairn::motor
