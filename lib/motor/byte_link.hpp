// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
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

/// Opens a line, each time that it is called. An error says in words why it cannot, and what to do.
using OpenLine = std::function<Result<std::unique_ptr<ByteLink>>()>;

/// Gives `line` at the first call; after that it is gone.
[[nodiscard]] inline OpenLine open_once(std::unique_ptr<ByteLink> line) {
  auto kept = std::make_shared<std::unique_ptr<ByteLink>>(std::move(line));
  return [kept]() -> Result<std::unique_ptr<ByteLink>> {
    if (*kept == nullptr) return fail("the line was lost, and there is no other");
    return std::move(*kept);
  };
}

}  // namespace cairn::motor
