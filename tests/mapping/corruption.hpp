// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace cairn::mapping::testing {

/// One random damage: bits flipped, a number overwritten, cut short, a piece lost, doubled or
/// zeroed.
inline std::vector<std::uint8_t> corrupted(std::vector<std::uint8_t> bytes, std::mt19937& random) {
  const auto any = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>{0, below - 1}(random);
  };
  if (bytes.empty()) return {1, 2, 3};
  const std::size_t at =
      any(2) == 0 ? any(bytes.size()) : any(std::min<std::size_t>(bytes.size(), 200));
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  const std::size_t length = 1 + any(std::min<std::size_t>(64, bytes.size() - at));
  const auto last = first + static_cast<std::ptrdiff_t>(length);
  switch (any(6)) {
    case 0:
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1U << any(8));
      break;
    case 1:
      std::generate(first, last, [&] { return static_cast<std::uint8_t>(random()); });
      break;
    case 2:
      bytes.resize(at);
      break;
    case 3:
      bytes.erase(first, last);
      break;
    case 4: {
      const std::vector<std::uint8_t> piece(first, last);
      bytes.insert(last, piece.begin(), piece.end());
      break;
    }
    default:
      std::fill(first, last, any(2) == 0 ? std::uint8_t{0} : std::uint8_t{0xff});
  }
  return bytes;
}

}  // namespace cairn::mapping::testing
