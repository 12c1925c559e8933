// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/result.hpp"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace cairn::messages {

using Bytes = std::vector<std::uint8_t>;

/// How hard zstd looks for repetitions.
enum class Redundancy {
  kSkewed,    ///< values of unequal frequency, no repetitions worth the search
  kRepeated,  ///< repetitions
};

/// Appends streams to `packed`, each as one zstd frame.
class StreamWriter {
 public:
  StreamWriter(Bytes& packed, Redundancy redundancy);

  void append(std::span<const std::uint8_t> raw);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  Bytes& packed_;
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
};

/// Reads what a StreamWriter wrote, stream after stream. All streams together unpack to at most
/// `limit_bytes`; a stream that says more is refused before memory is taken for it.
class StreamReader {
 public:
  StreamReader(std::span<const std::uint8_t> packed, std::size_t limit_bytes);

  [[nodiscard]] Result<Bytes> next();
  [[nodiscard]] bool at_end() const { return packed_.empty(); }

 private:
  struct Free {
    void operator()(ZSTD_DCtx_s* context) const;
  };
  std::span<const std::uint8_t> packed_;
  std::size_t limit_bytes_;
  std::unique_ptr<ZSTD_DCtx_s, Free> context_;
};

}  // namespace cairn::messages
