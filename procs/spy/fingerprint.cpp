// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/fingerprint.hpp"

#include <algorithm>
#include <vector>

namespace cairn::spy {
namespace {

constexpr std::uint64_t kHashStart = 0x12345678;

/// LCM shifts a signed number to the right.
std::uint64_t shifted_right_55(std::uint64_t value) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(value) >> 55);
}

void mix(std::uint64_t& hash, std::size_t value) {
  const auto byte = static_cast<std::int8_t>(value);
  hash = ((hash << 8) ^ shifted_right_55(hash)) + static_cast<std::uint64_t>(byte);
}

void mix(std::uint64_t& hash, const std::string& text) {
  mix(hash, text.size());
  for (const char c : text) mix(hash, static_cast<std::size_t>(static_cast<unsigned char>(c)));
}

std::uint64_t hash_of_own_fields(const MessageType& type) {
  std::uint64_t hash = kHashStart;
  for (const Field& field : type.fields) {
    mix(hash, field.name);
    if (field.primitive) mix(hash, field.type);
    mix(hash, field.dimensions.size());
    for (const Dimension& dimension : field.dimensions) {
      mix(hash, std::size_t{dimension.count_field.has_value()});
      mix(hash, dimension.text);
    }
  }
  return hash;
}

std::uint64_t hash_within(const std::map<std::string, MessageType, std::less<>>& types,
                          const MessageType& type, std::vector<const MessageType*>& around) {
  if (std::find(around.begin(), around.end(), &type) != around.end()) return 0;
  around.push_back(&type);
  std::uint64_t hash = hash_of_own_fields(type);
  for (const Field& field : type.fields) {
    if (!field.primitive) hash += hash_within(types, types.find(field.type)->second, around);
  }
  around.pop_back();
  return (hash << 1) + (hash >> 63);
}

}  // namespace

std::uint64_t fingerprint(const std::map<std::string, MessageType, std::less<>>& types,
                          const MessageType& type) {
  std::vector<const MessageType*> around;
  return hash_within(types, type, around);
}

}  // namespace cairn::spy
