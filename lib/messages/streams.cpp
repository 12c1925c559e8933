// SPDX-License-Identifier: Apache-2.0
#include "messages/streams.hpp"

#include <zstd.h>

#include <string>

namespace cairn::messages {
namespace {

constexpr int kLevel = 1;
constexpr int kSkewedWindowLog = 18;
constexpr int kSkewedHashLog = 6;
constexpr int kSkewedMinMatch = 7;

}  // namespace

void StreamWriter::Free::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }
void StreamReader::Free::operator()(ZSTD_DCtx_s* context) const { ZSTD_freeDCtx(context); }

StreamWriter::StreamWriter(Bytes& packed, Redundancy redundancy)
    : packed_(packed), context_(ZSTD_createCCtx()) {
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kLevel);
  if (redundancy == Redundancy::kSkewed) {
    // Short chance repetitions cost more than the entropy coder alone.
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_windowLog, kSkewedWindowLog);
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_hashLog, kSkewedHashLog);
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_minMatch, kSkewedMinMatch);
  }
}

void StreamWriter::append(std::span<const std::uint8_t> raw) {
  const std::size_t before = packed_.size();
  const std::size_t room = ZSTD_compressBound(raw.size());
  packed_.resize(before + room);
  packed_.resize(before + ZSTD_compress2(context_.get(), packed_.data() + before, room, raw.data(),
                                         raw.size()));
}

StreamReader::StreamReader(std::span<const std::uint8_t> packed, std::size_t limit_bytes)
    : packed_(packed), limit_bytes_(limit_bytes), context_(ZSTD_createDCtx()) {}

Result<Bytes> StreamReader::next() {
  const std::size_t frame_size = ZSTD_findFrameCompressedSize(packed_.data(), packed_.size());
  const auto raw_size = ZSTD_getFrameContentSize(packed_.data(), packed_.size());
  if (ZSTD_isError(frame_size) != 0 || raw_size == ZSTD_CONTENTSIZE_ERROR ||
      raw_size == ZSTD_CONTENTSIZE_UNKNOWN) {
    return fail("a packed stream is damaged or ends too early");
  }
  if (raw_size > limit_bytes_) {
    return fail("a stream says that it unpacks to " + std::to_string(raw_size) +
                " bytes, more than can belong here");
  }
  limit_bytes_ -= raw_size;
  Bytes raw(raw_size);
  const std::size_t got =
      ZSTD_decompressDCtx(context_.get(), raw.data(), raw.size(), packed_.data(), frame_size);
  if (ZSTD_isError(got) != 0) return fail(std::string("zstd: ") + ZSTD_getErrorName(got));
  if (got != raw_size) return fail("a stream unpacks to fewer bytes than it says");
  packed_ = packed_.subspan(frame_size);
  return raw;
}

}  // namespace cairn::messages
