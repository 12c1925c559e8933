// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/result.hpp"

namespace cairn::motor {

/// A line that carries bytes both ways, between a motor process and a wheel controller: a serial
/// port, the other end of a pseudo-terminal, or memory (lockstep, tests). Neither call waits.
class ByteLink {
 public:
  virtual ~ByteLink() = default;
  /// All that has come since the last call; nothing is an empty vector. An error: the line is gone.
  [[nodiscard]] virtual Result<std::vector<std::uint8_t>> read() = 0;
  /// An error: the line is gone, or takes no more now.
  [[nodiscard]] virtual Result<void> write(std::span<const std::uint8_t> bytes) = 0;
};

}  // namespace cairn::motor
