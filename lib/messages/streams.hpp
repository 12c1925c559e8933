// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.hpp"

namespace cairn::messages {

using Bytes = std::vector<std::uint8_t>;

/// How hard zstd looks for repetitions.
enum class Redundancy {
  kSkewed,    ///< values of unequal frequency, no repetitions worth the search
  kRepeated,  ///< repetitions
};

/// Appends `raw` to `packed` as a stream: two sizes of 32 bits, little end first, then a zstd
/// frame.
void append_stream(Bytes& packed, std::span<const std::uint8_t> raw, Redundancy redundancy);

/// Reads what append_stream wrote, stream after stream. All streams together unpack to at most
/// `limit_bytes`; a stream that says more is refused before memory is taken for it.
class StreamReader {
 public:
  StreamReader(std::span<const std::uint8_t> packed, std::size_t limit_bytes)
      : packed_(packed), limit_bytes_(limit_bytes) {}

  [[nodiscard]] Result<Bytes> next();
  [[nodiscard]] bool at_end() const { return packed_.empty(); }

 private:
  std::span<const std::uint8_t> packed_;
  std::size_t limit_bytes_;
};

}  // namespace cairn::messages
