// SPDX-License-Identifier: Apache-2.0
#include "messages/streams.hpp"

#include <zstd.h>

#include <memory>
#include <string>

namespace cairn::messages {
namespace {

constexpr std::size_t kSizeBytes = 4;
constexpr int kLevel = 1;
constexpr int kSkewedWindowLog = 18;
constexpr int kSkewedHashLog = 6;
constexpr int kSkewedMinMatch = 7;

struct FreeCompressor {
  void operator()(ZSTD_CCtx* compressor) const { ZSTD_freeCCtx(compressor); }
};

void append_size(Bytes& bytes, std::size_t size) {
  for (std::size_t i = 0; i < kSizeBytes; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(size >> (8 * i)));
  }
}

std::size_t size_at(std::span<const std::uint8_t> bytes) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < kSizeBytes; ++i) size |= std::size_t{bytes[i]} << (8 * i);
  return size;
}

}  // namespace

void append_stream(Bytes& packed, std::span<const std::uint8_t> raw, Redundancy redundancy) {
  const std::unique_ptr<ZSTD_CCtx, FreeCompressor> compressor(ZSTD_createCCtx());
  ZSTD_CCtx_setParameter(compressor.get(), ZSTD_c_compressionLevel, kLevel);
  if (redundancy == Redundancy::kSkewed) {
    // Short chance repetitions cost more than the entropy coder alone.
    ZSTD_CCtx_setParameter(compressor.get(), ZSTD_c_windowLog, kSkewedWindowLog);
    ZSTD_CCtx_setParameter(compressor.get(), ZSTD_c_hashLog, kSkewedHashLog);
    ZSTD_CCtx_setParameter(compressor.get(), ZSTD_c_minMatch, kSkewedMinMatch);
  }
  Bytes frame(ZSTD_compressBound(raw.size()));
  frame.resize(
      ZSTD_compress2(compressor.get(), frame.data(), frame.size(), raw.data(), raw.size()));
  append_size(packed, raw.size());
  append_size(packed, frame.size());
  packed.insert(packed.end(), frame.begin(), frame.end());
}

Result<Bytes> StreamReader::next() {
  if (packed_.size() < 2 * kSizeBytes) return fail("packed bytes end too early");
  const std::size_t raw_size = size_at(packed_);
  const std::size_t frame_size = size_at(packed_.subspan(kSizeBytes));
  packed_ = packed_.subspan(2 * kSizeBytes);
  if (frame_size > packed_.size()) return fail("packed bytes end too early");
  const auto frame = packed_.first(frame_size);
  packed_ = packed_.subspan(frame_size);
  if (raw_size > limit_bytes_) {
    return fail("a stream says that it unpacks to " + std::to_string(raw_size) +
                " bytes, more than can belong here");
  }
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != raw_size) {
    return fail("a stream's size is not that of its zstd frame");
  }
  limit_bytes_ -= raw_size;
  Bytes raw(raw_size);
  const std::size_t got = ZSTD_decompress(raw.data(), raw.size(), frame.data(), frame.size());
  if (ZSTD_isError(got) != 0) return fail(std::string("zstd: ") + ZSTD_getErrorName(got));
  if (got != raw_size) return fail("a stream unpacks to fewer bytes than it says");
  return raw;
}

}  // namespace cairn::messages
