// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/printable.hpp"

#include <cstdint>

namespace cairn::spy {
namespace {

std::uint8_t byte_at(std::string_view text, std::size_t at) {
  return static_cast<std::uint8_t>(text[at]);
}

bool continues(std::string_view text, std::size_t at) {
  return at < text.size() && (byte_at(text, at) & 0xC0) == 0x80;
}

/// Bytes of the well-formed UTF-8 character at `at` (RFC 3629, section 4); 0 where there is none.
std::size_t character_size(std::string_view text, std::size_t at) {
  const std::uint8_t first = byte_at(text, at);
  const std::uint8_t second = continues(text, at + 1) ? byte_at(text, at + 1) : 0;
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return second != 0 ? 2 : 0;
  if (!continues(text, at + 2)) return 0;
  if (first >= 0xE0 && first < 0xF0) {
    const bool overlong = first == 0xE0 && second < 0xA0;
    const bool surrogate = first == 0xED && second >= 0xA0;
    return second != 0 && !overlong && !surrogate ? 3 : 0;
  }
  if (first >= 0xF0 && first < 0xF5 && continues(text, at + 3)) {
    const bool overlong = first == 0xF0 && second < 0x90;
    const bool beyond_unicode = first == 0xF4 && second >= 0x90;
    return second != 0 && !overlong && !beyond_unicode ? 4 : 0;
  }
  return 0;
}

bool controls(std::string_view text, std::size_t at, std::size_t size) {
  const std::uint8_t first = byte_at(text, at);
  if (size == 1) return first < 0x20 || first == 0x7F;
  return size == 2 && first == 0xC2 && byte_at(text, at + 1) < 0xA0;
}

}  // namespace

std::string printable(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t size = character_size(text, at);
    if (size > 0 && !controls(text, at, size)) {
      result += text.substr(at, size);
      at += size;
    } else {
      const std::uint8_t byte = byte_at(text, at++);
      result += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return result;
}

std::size_t width_of(std::string_view text) {
  std::size_t width = 0;
  for (std::size_t at = 0; at < text.size(); ++at) width += continues(text, at) ? 0 : 1;
  return width;
}

std::string shortened(std::string_view text, std::size_t width) {
  if (width_of(text) <= width) return std::string(text);
  const std::string_view mark = std::string_view("...").substr(0, width);
  std::size_t kept = 0;
  for (std::size_t columns = 0; kept < text.size(); ++kept) {
    if (!continues(text, kept) && columns++ == width - mark.size()) break;
  }
  return std::string(text.substr(0, kept)).append(mark);
}

}  // namespace cairn::spy
