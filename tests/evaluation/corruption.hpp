// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <string>

namespace cairn::evaluation {

/// The bytes with up to four random bytes changed, inserted or cut away, or the end missing.
inline std::string corrupted(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t limit) { return random() % limit; };
  for (std::size_t edits = 1 + below(4); edits > 0 && !bytes.empty(); --edits) {
    const std::size_t at = below(bytes.size());
    const char byte = static_cast<char>(below(256));
    switch (below(4)) {
      case 0:
        bytes[at] = byte;
        break;
      case 1:
        bytes.insert(at, 1 + below(3), byte);
        break;
      case 2:
        bytes.erase(at, 1 + below(8));
        break;
      default:
        bytes.resize(at);
    }
  }
  return bytes;
}

}  // namespace cairn::evaluation
