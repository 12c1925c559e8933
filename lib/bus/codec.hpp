// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/header_t.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace cairn::bus {

/// The header of a message of any type: its first field, behind the 8-byte fingerprint.
[[nodiscard]] inline Result<header_t> peek_header(std::span<const std::uint8_t> bytes) {
  constexpr int kFingerprintSize = 8;
  header_t header{};
  const int size = static_cast<int>(bytes.size());
  if (header._decodeNoHash(bytes.data(), kFingerprintSize, size - kFingerprintSize) < 0) {
    return fail(std::to_string(size) + " bytes are too few for a message with a header");
  }
  return header;
}

/// The message in these bytes. Refused: bytes of another type or of another version of it, forged
/// lengths, bytes left over, and a header that no sender of ours writes.
template <class Message>
[[nodiscard]] Result<Message> decode(std::span<const std::uint8_t> bytes) {
  Message message{};
  const int size = static_cast<int>(bytes.size());
  const int decoded = message.decode(bytes.data(), 0, size);
  if (decoded < 0)
    return fail("the bytes are not a whole message of type " + std::string(Message::getTypeName()));
  if (decoded != size) {
    return fail(std::to_string(size - decoded) + " bytes too many for a message of type " +
                Message::getTypeName());
  }
  if (message.header.utime < 0) return fail("header.utime is negative");
  if (message.header.sequence < 0) return fail("header.sequence is negative");
  return message;
}

/// The bytes of a message; an error if a count field and its vector differ in size.
template <class Message>
[[nodiscard]] Result<std::vector<std::uint8_t>> encode(const Message& message) {
  if (!message.counts_agree()) {
    return fail(std::string(Message::getTypeName()) +
                ": a count field differs from the size of its vector");
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  const int encoded = message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  if (encoded != static_cast<int>(bytes.size()))
    return fail(std::string(Message::getTypeName()) + ": cannot be encoded");
  return bytes;
}

}  // namespace cairn::bus
